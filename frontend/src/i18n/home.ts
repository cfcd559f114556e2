import { translator } from "./index";

export const t = translator({
  title: { zh: "入木三分", en: "Three tenths into the wood" },
  first: {
    zh: "相傳王羲之在木板上寫字，刻工削去三分，墨還在裡面。",
    en: "It is told that when a carver planed down a board on which Wang Xizhi had written, the ink went three tenths of an inch into the wood.",
  },
  second: {
    zh: "這裡把碑帖變成有高低的表面：移動燈光，就看見筆走過的地方。",
    en: "Here calligraphy becomes a surface: move the lamp over it and see where the brush has been.",
  },
  third: {
    zh: "臨寫一個字，就知道它和範字差在哪裡，下一次怎麼寫。",
    en: "Write a character after a master, and learn where yours differs and what to do about it.",
  },
  toGallery: { zh: "看展廳", en: "To the gallery" },
  toStudio: { zh: "寫一個字", en: "Write a character" },
  works: { zh: "展廳裡有 {n} 件作品", en: "{n} works in the gallery" },
  lampHint: { zh: "移動指標，燈就跟著走。", en: "Move the pointer: the lamp follows." },
  lampHintTouch: { zh: "手指在圖上移動，燈就跟著走。", en: "Move a finger over the picture: the lamp follows." },
  useTilt: { zh: "傾斜手機來移動燈", en: "Move the lamp by tilting the phone" },
  noTilt: { zh: "這支手機沒有答應讓網頁知道它怎麼傾斜。", en: "This phone does not tell the page how it is tilted." },
  seeWork: { zh: "看這件作品：{title}", en: "See this work: {title}" },
  empty: { zh: "展廳裡還沒有作品。", en: "There are no works in the gallery yet." },
  about: { zh: "關於這裡", en: "About" },
  aboutMarks: { zh: "評分是什麼意思", en: "What a mark means" },
  marksAre: {
    zh: "分數從 0 到 100，估計一組人會給這張臨作的平均分，並附一個區間：十張裡約有八張，眾人的平均落在區間裡。",
    en: "A mark, from 0 to 100, estimates the mean of what a panel of people would give the copy. It comes with an interval: for about eight copies in ten the panel’s mean lies inside it.",
  },
  marksFrom: {
    zh: "它依眾人給學書者楷書臨作的評分校準；其他書體沒有這樣的評分作依據，區間因此放寬。",
    en: "It is calibrated on people’s marks of learners’ copies in regular script. For other scripts there are no such marks, so the interval is wider.",
  },
  marksCompare: {
    zh: "它把一張臨作和一件範字對齊了再比；傾斜、位置、大小另列。它不評斷人，也不代替老師。",
    en: "It compares one copy with one master after both are aligned; lean, place and size are listed apart. It is no verdict on a person, and no substitute for a teacher.",
  },
  marksRefuse: {
    zh: "看不準的不給分，也說明為什麼。",
    en: "What cannot be judged gets no mark, and the reason is said.",
  },
  aboutHeights: { zh: "高度從何而來", en: "Where heights come from" },
  aboutLicences: { zh: "來源與授權", en: "Sources and licences" },
  api: { zh: "給程式用的介面", en: "For programs" },
  software: { zh: "rumu {version}，Apache-2.0 授權", en: "rumu {version}, licensed under Apache-2.0" },
});
