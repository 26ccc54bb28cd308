// Which words play at a beat, and where they are after edits.

/** Start line, start column, end line, end column. */
export type WordRange = readonly [number, number, number, number];

/** What the server reports once for each save that plays; ranges that an edit has touched are null. */
export interface Evaluated {
  uri: string;
  version: number;
  generation: number;
  from: number; // the moments are known from this beat on
  ranges: readonly (WordRange | null)[];
  robots: Record<string, Stretch>;
}

/** First beat, last beat, and the indices of the ranges that play; sorted, without overlaps. */
export type Moment = readonly [number, number, readonly number[]];

interface Stretch {
  moments: readonly Moment[];
  until: number | null; // the moments are known up to this beat; null: to the end
}

export interface Change {
  range: { start: { line: number; character: number }; end: { line: number; character: number } };
  text: string;
}

/** What plays at a beat, and the next beat at which that changes. */
export function playing(
  evaluated: Evaluated,
  beat: number,
  isSilent: (robot: string) => boolean,
): { ranges: WordRange[]; next: number } {
  const indices = new Set<number>();
  let next = Infinity;
  for (const [robot, { moments }] of Object.entries(evaluated.robots)) {
    const after = firstAfter(moments, beat);
    const current = moments[after - 1];
    const plays = current !== undefined && beat < current[1];
    if (plays && !isSilent(robot)) current[2].forEach((index) => indices.add(index));
    next = Math.min(next, plays ? current[1] : (moments[after]?.[0] ?? Infinity));
  }
  const ranges = [...indices].map((index) => evaluated.ranges[index]).filter((range) => range !== null);
  return { ranges: ranges as WordRange[], next };
}

/** Whether it is known what plays at a beat. */
export function reaches({ robots, from }: Evaluated, beat: number): boolean {
  return from <= beat && Object.values(robots).every(({ until }) => until === null || beat < until);
}

/** Where the ranges are after an edit; a range that it touches becomes null. */
export function edited(ranges: readonly (WordRange | null)[], change: Change): (WordRange | null)[] {
  return ranges.map((range) => range && moved(range, change));
}

function moved(range: WordRange, { range: { start, end }, text }: Change): WordRange | null {
  const [line, column, lastLine, lastColumn] = range;
  if (isBefore(lastLine, lastColumn, start)) return range;
  if (lastLine === start.line && lastColumn === start.character) return /^[\p{L}\p{N}_]/u.test(text) ? null : range;
  const touches = line === end.line && column === end.character;
  if (!touches && !isBefore(end.line, end.character, { line, character: column })) return null;
  if (touches && /[\p{L}\p{N}_]$/u.test(text)) return null;

  const lines = text.split(/\r\n|\r|\n/);
  const down = lines.length - 1 - (end.line - start.line);
  const right = (lines.at(-1) ?? "").length + (lines.length === 1 ? start.character : 0) - end.character;
  const shift = (its: number): number => (its === end.line ? right : 0);
  return [line + down, column + shift(line), lastLine + down, lastColumn + shift(lastLine)];
}

function isBefore(line: number, column: number, other: { line: number; character: number }): boolean {
  return line < other.line || (line === other.line && column < other.character);
}

/** The index of the first moment that begins after a beat. */
function firstAfter(moments: readonly Moment[], beat: number): number {
  let low = 0;
  let high = moments.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((moments[middle] as Moment)[0] <= beat) low = middle + 1;
    else high = middle;
  }
  return low;
}
