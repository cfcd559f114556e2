// Line drawings of 20 x 20, drawn for these pages.

const DRAWN = {
  sheet: "M4 3h12v14H4z M7 7h6 M7 10h6 M7 13h4",
  surface: "M2 13c3-6 5-6 8-2s5 2 8-3 M2 17c3-5 5-5 8-2s5 2 8-3",
  mesh: "M3 5l7-2 7 2v9l-7 3-7-3z M3 5l7 3 7-3 M10 8v9 M3 9.5l7 3 7-3",
  heights: "M3 17V11h3v6 M8.5 17V7h3v10 M14 17V3h3v14",
  contours: "M10 3c5 0 7 3 7 7s-3 7-7 7-7-2-7-6 3-8 7-8z M10 6.500c2.500 0 4 1.500 4 3.500s-1.500 3.500-4 3.500-3.500-1-3.500-3 1.500-4 3.500-4z M10 9.500v1",
  light: "M10 6.500a3.500 3.500 0 1 0 0 7 3.500 3.500 0 0 0 0-7z M10 1.500v2 M10 16.500v2 M1.500 10h2 M16.500 10h2 M4 4l1.400 1.400 M14.600 14.600L16 16 M16 4l-1.400 1.400 M5.400 14.600L4 16",
  move: "M10 2v16 M2 10h16 M10 2L7.500 4.500 M10 2l2.500 2.500 M10 18l-2.500-2.500 M10 18l2.500-2.500 M2 10l2.500-2.500 M2 10l2.500 2.500 M18 10l-2.500-2.500 M18 10l-2.500 2.500",
  section: "M2 16h16 M3 12c2 0 2-7 5-7s2 5 4 5 2-3 5-3",
  ruler: "M2 13L13 2l5 5L7 18z M6 9l2 2 M9 6l2.500 2.500 M12 3l2 2 M4.500 10.500L6 12",
  lens: "M8.500 3a5.500 5.500 0 1 0 0 11 5.500 5.500 0 0 0 0-11z M12.500 12.500L18 18",
  pin: "M10 18s6-6 6-10.500A6 6 0 0 0 4 7.500C4 12 10 18 10 18z M10 5.500a2 2 0 1 0 0 4 2 2 0 0 0 0-4z",
  pair: "M3 4h6v12H3z M11 4h6v12h-6z",
  full: "M3 8V3h5 M12 3h5v5 M17 12v5h-5 M8 17H3v-5",
  link: "M8 12l4-4 M9 6l2-2a3.500 3.500 0 0 1 5 5l-2 2 M11 14l-2 2a3.500 3.500 0 0 1-5-5l2-2",
  save: "M10 3v9 M6 8.500l4 4 4-4 M3 17h14",
  camera: "M2.500 6h4l1.500-2h4l1.500 2h4v10h-15z M10 8a3 3 0 1 0 0 6 3 3 0 0 0 0-6z",
  help: "M7 7a3 3 0 1 1 4.500 2.600c-1 .6-1.500 1.200-1.500 2.400 M10 15.500v.5",
  home: "M4 4v5h5 M4.500 9A6.500 6.500 0 1 1 4 12.500",
  headset: "M2 7h16v7h-5l-1.500-2h-3L7 14H2z",
  play: "M6 4l10 6-10 6z",
  previous: "M12 4l-6 6 6 6",
  next: "M8 4l6 6-6 6",
  close: "M5 5l10 10 M15 5L5 15",
  edit: "M3 17l1-4L14 3l3 3L7 16z",
  add: "M10 4v12 M4 10h12",
  search: "M8.500 3a5.500 5.500 0 1 0 0 11 5.500 5.500 0 0 0 0-11z M12.500 12.500L17 17",
  lamps: "M5 5.500a2 2 0 1 0 0 .1z M15 5.500a2 2 0 1 0 0 .1z M10 3a2 2 0 1 0 0 .1z M3 16h14 M5 9l3 5 M15 9l-3 5 M10 7v6",
} as const;

export type IconName = keyof typeof DRAWN;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 20 20" width="20" height="20" aria-hidden="true">
      <path d={DRAWN[name]} />
    </svg>
  );
}
