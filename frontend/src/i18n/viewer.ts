export const viewer = {
  picture: { zh: "作品圖片", en: "Picture of the work" },
  noWebgl: {
    zh: "這個瀏覽器沒有 WebGL2，只能顯示圖片，不能轉動燈光。",
    en: "This browser has no WebGL2: here is the picture; its light cannot be turned.",
  },
} as const;
