// Titles as they stand in a numbered list.

const NUMBER = /^\s*(?:\d+|[一二三四五六七八九十百]+)\s*[.、．:：)）]\s*(?=\S)/u;

/** A title without the number that it brings: 「1. The upright」 and 「一、豎」 lose it, 「一個水」 does not. */
export const unnumbered = (title: string): string => title.replace(NUMBER, "");
