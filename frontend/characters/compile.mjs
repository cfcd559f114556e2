// Compiles what is known of characters into one compact file of the Python package; a part of `npm run build`.
//
// Outlines and centre lines in stroke order come from hanzi-writer-data (Arphic Public License), names of strokes
// and structure from cnchar (MIT). cnchar knows the simplified characters; a stroke of any other is named like the
// strokes nearest to it in shape, and its structure is that of its simplified form where its strokes allow it.
// How the file is laid out is told in src/rumu/characters/stroke_data.py, which reads it.

import { createHash } from "node:crypto";
import { copyFileSync, existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, constants } from "node:zlib";

const require = createRequire(import.meta.url);
const here = dirname(fileURLToPath(import.meta.url));
const target = join(here, "..", "..", "src", "rumu", "characters");
const source = dirname(require.resolve("hanzi-writer-data/package.json"));
const cnchar = require("cnchar");
cnchar.use(require("cnchar-order"), require("cnchar-radical"));

const MAGIC = "rumu characters 2";
const PER_BLOCK = 64; // characters that are compressed together
const LINE_GRID = 6; // units of the 1,024 of the square to which centre lines are rounded
const OUTLINE_GRID = 7; // the same for outlines
const STRAY = 5; // units by which a centre line may be off after points are left out
const TOP = 900; // y of the top of the square in the source, where y points up
const STRUCTURES = "左右结构 上下结构 独体结构 半包围结构 全包围结构 品字结构 上中下结构 左中右结构".split(" ");
const SAMPLES = 12; // points of a centre line that are compared
const SECTORS = 24; // of the direction from beginning to end, by which strokes are sorted for the search
const NEIGHBOURS = 5;
const EXAMPLES = 150; // of each name in each sector; more take longer and name no better
const COMMANDS = "MLQCZ";
const POINTS = { M: 1, L: 1, Q: 2, C: 3, Z: 0 };

/** A centre line as numbers: shape, directions and length, so that near numbers are like strokes. */
function describe(line) {
    const along = [0];
    for (let k = 1; k < line.length; k++)
        along.push(along[k - 1] + Math.hypot(line[k][0] - line[k - 1][0], line[k][1] - line[k - 1][1]));
    const length = Math.max(along.at(-1), 1e-9);
    const points = [];
    for (let i = 0, k = 1; i < SAMPLES; i++) {
        const at = (i / (SAMPLES - 1)) * length;
        while (k < line.length - 1 && along[k] < at) k++;
        const share = line.length < 2 ? 0 : (at - along[k - 1]) / Math.max(along[k] - along[k - 1], 1e-9);
        const [a, b] = line.length < 2 ? [line[0], line[0]] : [line[k - 1], line[k]];
        points.push([a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]);
    }
    const middle = [0, 1].map((axis) => points.reduce((sum, p) => sum + p[axis], 0) / SAMPLES);
    const extents = [0, 1].map((axis) => Math.max(...points.map((p) => p[axis])) - Math.min(...points.map((p) => p[axis])));
    const size = Math.max(...extents, 1);
    const numbers = points.flatMap((p) => [(p[0] - middle[0]) / size, (p[1] - middle[1]) / size]);
    for (let k = 1; k < SAMPLES; k++) {
        const step = [points[k][0] - points[k - 1][0], points[k][1] - points[k - 1][1]];
        const long = Math.max(Math.hypot(...step), 1e-9);
        numbers.push((0.35 * step[0]) / long, (0.35 * step[1]) / long);
    }
    numbers.push(0.8 * Math.log(length / 500));
    const end = points.at(-1);
    const sector = Math.floor(((Math.atan2(end[1] - points[0][1], end[0] - points[0][0]) / (2 * Math.PI) + 1) % 1) * SECTORS);
    return { numbers: Float32Array.from(numbers), sector };
}

/** The points without which a line would be off by more than STRAY (Douglas and Peucker 1973). */
function simplify(line) {
    const [a, b] = [line[0], line.at(-1)];
    const [across, up] = [b[0] - a[0], b[1] - a[1]];
    const long = Math.max(Math.hypot(across, up), 1e-9);
    const away = line.map((p) =>
        long < 1 ? Math.hypot(p[0] - a[0], p[1] - a[1]) : Math.abs((p[0] - a[0]) * up - (p[1] - a[1]) * across) / long,
    );
    const farthest = away.indexOf(Math.max(...away));
    if (line.length < 3 || away[farthest] <= STRAY) return [a, b];
    return [...simplify(line.slice(0, farthest + 1)).slice(0, -1), ...simplify(line.slice(farthest))];
}

/** The letter that most of the nearest named strokes have. */
function nameLike(stroke, named) {
    const nearest = []; // [squared distance, letter], nearest first
    const near = [-1, 0, 1].map((turn) => named[(stroke.sector + turn + SECTORS) % SECTORS]);
    for (const examples of near.some((sector) => sector.length) ? near : named) {
        for (const other of examples) {
            const worst = nearest.length < NEIGHBOURS ? Infinity : nearest[NEIGHBOURS - 1][0];
            let sum = 0;
            for (let k = 0; k < stroke.numbers.length && sum < worst; k++) {
                const apart = stroke.numbers[k] - other.numbers[k];
                sum += apart * apart;
            }
            if (sum >= worst) continue;
            nearest.push([sum, other.letter]);
            nearest.sort((a, b) => a[0] - b[0]);
            nearest.length = Math.min(nearest.length, NEIGHBOURS);
        }
    }
    const votes = new Map();
    for (const [, letter] of nearest) votes.set(letter, (votes.get(letter) ?? 0) + 1);
    return [...votes].sort((a, b) => b[1] - a[1])[0][0];
}

/** Whether the strokes stand in so many groups along an axis (0: side by side), the first ones written first. */
function standsApart(lines, axis, groups) {
    const middles = lines.map((line) => line.reduce((sum, p) => sum + p[axis], 0) / line.length);
    const sign = axis === 0 ? 1 : -1; // y points up in the source
    for (let first = 1; first < lines.length; first++) {
        const before = Math.max(...middles.slice(0, first).map((m) => sign * m));
        const after = Math.min(...middles.slice(first).map((m) => sign * m));
        if (before < after) return groups <= 2 || standsApart(lines.slice(first), axis, groups - 1);
    }
    return false;
}

/** Whether the first one to three strokes, or the last two to four, reach around the middles of all others. */
function isEnclosed(lines) {
    const reachesAround = (outer, inner) => {
        const points = outer.flat();
        return inner.every((line) =>
            [0, 1].every((axis) => {
                const middle = line.reduce((sum, p) => sum + p[axis], 0) / line.length;
                return Math.min(...points.map((p) => p[axis])) <= middle && middle <= Math.max(...points.map((p) => p[axis]));
            }),
        );
    };
    return (
        [1, 2, 3].some((k) => k < lines.length && reachesAround(lines.slice(0, k), lines.slice(k))) ||
        [2, 3, 4].some((k) => k < lines.length && reachesAround(lines.slice(-k), lines.slice(0, -k)))
    );
}

function structureOf(character, simplified, lines) {
    const known = STRUCTURES.indexOf(cnchar.radical(character)[0]?.struct);
    if (known >= 0) return known + 1;
    const like = simplified && STRUCTURES.indexOf(cnchar.radical(simplified)[0]?.struct);
    if (like === undefined || like < 0) return 0;
    const arranged = { 0: [0, 2], 1: [1, 2], 6: [1, 3], 7: [0, 3] }[like];
    if (arranged) return standsApart(lines, ...arranged) ? like + 1 : 0;
    return (like === 3 || like === 4) && isEnclosed(lines) ? like + 1 : 0;
}

/** After how many strokes the radical ends, if it is written first, or begins, if it is written last; else 0. */
function radicalBorder({ radStrokes, strokes }) {
    const own = [...(radStrokes ?? [])].sort((a, b) => a - b);
    if (!own.length || own.length === strokes.length || own.at(-1) - own[0] !== own.length - 1) return 0;
    if (own[0] === 0) return own.length;
    return own.at(-1) === strokes.length - 1 ? own[0] : 0;
}

/** Numbers of 7 bits a byte, the lowest first, signs in the lowest bit. */
class Numbers {
    bytes = [];
    add(value) {
        let rest = value < 0 ? -2 * value - 1 : 2 * value;
        while (rest > 127) {
            this.bytes.push((rest & 127) | 128);
            rest >>= 7;
        }
        this.bytes.push(rest);
    }
}

function blockOf(characters) {
    const [heads, lines, commands, outlines] = Array.from({ length: 4 }, () => new Numbers());
    for (const { structure, letters, data } of characters) {
        heads.add(structure);
        heads.add(radicalBorder(data));
        heads.add(letters.length);
        let previous = [0, 0]; // where the outline before began
        data.strokes.forEach((path, k) => {
            heads.add(letters.charCodeAt(k) - "a".charCodeAt(0));
            const line = simplify(data.medians[k]);
            heads.add(line.length);
            let [x, y] = [0, 0];
            for (const point of line) {
                const [column, row] = [Math.round(point[0] / LINE_GRID), Math.round((TOP - point[1]) / LINE_GRID)];
                lines.add(column - x);
                lines.add(row - y);
                [x, y] = [column, row];
            }
            const words = path.match(/[A-Z]|-?[\d.]+/g);
            const numbers = words.filter((word) => !/[A-Z]/.test(word)).map(Number);
            const own = words.filter((word) => /[A-Z]/.test(word));
            heads.add(own.length);
            for (const command of own) commands.add(COMMANDS.indexOf(command));
            const grid = numbers.map((n, i) => Math.round((i % 2 ? TOP - n : n) / OUTLINE_GRID));
            [x, y] = previous;
            for (let i = 0, at = 0; i < own.length; i++) {
                const count = POINTS[own[i]];
                if (count === 0) continue;
                const [right, down] = grid.slice(at + 2 * count - 2, at + 2 * count); // where the piece ends
                outlines.add(right - x);
                outlines.add(down - y);
                for (let c = 0; c < count - 1; c++) { // control points, from the middle of the piece
                    outlines.add(grid[at + 2 * c] - ((x + right) >> 1));
                    outlines.add(grid[at + 2 * c + 1] - ((y + down) >> 1));
                }
                [x, y] = [right, down];
                at += 2 * count;
                if (own[i] === "M") previous = [x, y];
            }
        });
    }
    const sizes = new Numbers();
    const parts = [heads, lines, commands, outlines];
    for (const part of parts) sizes.add(part.bytes.length);
    const whole = Buffer.concat([sizes, ...parts].map((part) => Buffer.from(part.bytes)));
    return brotliCompressSync(whole, {
        params: { [constants.BROTLI_PARAM_QUALITY]: 11, [constants.BROTLI_PARAM_SIZE_HINT]: whole.length },
    });
}

/** A digest of all that the file is made from, so that it is made again only when some of it changes. */
function inputsDigest(variants) {
    const packages = ["hanzi-writer-data", "cnchar", "cnchar-order", "cnchar-radical"];
    const versions = packages.map((name) => `${name} ${require(`${name}/package.json`).version}`);
    return createHash("sha256").update([readFileSync(fileURLToPath(import.meta.url)), variants, ...versions].join("\n")).digest("hex");
}

function main() {
    const text = readFileSync(join(target, "..", "gallery", "variants.txt"), "utf8");
    const [file, stamp, digest] = [join(target, "strokes.bin"), join(target, ".compiled-from"), inputsDigest(text)];
    if (existsSync(file) && existsSync(stamp) && readFileSync(stamp, "utf8") === digest) return;
    const variants = [...text.replace(/\s/g, "")];
    const simplified = new Map();
    for (let k = 0; k + 1 < variants.length; k += 2) simplified.set(variants[k], variants[k + 1]);

    const characters = readdirSync(source)
        .filter((name) => name.endsWith(".json") && [...name.slice(0, -5)].length === 1)
        .map((name) => ({ character: name.slice(0, -5), data: JSON.parse(readFileSync(join(source, name), "utf8")) }))
        .sort((a, b) => a.character.codePointAt(0) - b.character.codePointAt(0));
    const named = Array.from({ length: SECTORS }, () => []);
    for (const entry of characters) {
        const { character, data } = entry;
        const letters = cnchar.stroke(character, "order")[0] ?? "";
        entry.structure = structureOf(character, simplified.get(character), data.medians);
        if (letters.length !== data.strokes.length) continue;
        entry.letters = letters;
        data.medians.forEach((line, k) => {
            const stroke = describe(line);
            named[stroke.sector].push({ numbers: stroke.numbers, letter: letters[k] });
        });
    }
    for (const [k, sector] of named.entries()) {
        const counts = new Map();
        for (const { letter } of sector) counts.set(letter, (counts.get(letter) ?? 0) + 1);
        const seen = new Map();
        named[k] = sector.filter(({ letter }) => {
            const count = counts.get(letter), step = Math.max(count / EXAMPLES, 1), at = seen.get(letter) ?? 0;
            seen.set(letter, at + 1);
            return Math.floor(at / step) !== Math.floor((at - 1) / step); // evenly among all
        });
    }
    for (const entry of characters)
        entry.letters ??= entry.data.medians.map((line) => nameLike(describe(line), named)).join("");

    const blocks = [];
    for (let k = 0; k < characters.length; k += PER_BLOCK) blocks.push(blockOf(characters.slice(k, k + PER_BLOCK)));
    const index = new Uint32Array(2 + characters.length + blocks.length);
    index.set([characters.length, PER_BLOCK, ...characters.map((c) => c.character.codePointAt(0)), ...blocks.map((b) => b.length)]);
    const whole = Buffer.concat([Buffer.from(MAGIC), Buffer.from(index.buffer), ...blocks]);
    writeFileSync(file, whole);
    copyFileSync(join(source, "ARPHICPL.TXT"), join(target, "ARPHICPL.TXT"));
    const derived = characters.filter((c) => !cnchar.stroke(c.character, "order")[0]).length;
    const unknown = characters.filter((c) => c.structure === 0).length;
    console.log(`${characters.length} characters, ${whole.length} bytes; strokes named by shape in ${derived}, structure unknown in ${unknown}`);
    writeFileSync(stamp, digest);
}

main();
