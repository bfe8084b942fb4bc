/** A recording under review: what the server told of it, what is selected, and what is asked of the server. */

import { serverAddress } from "../link";
import { News } from "../news";
import type { LabelSpan, RecordedSeries, Review, ReviewRequest } from "../protocol";
import { formatTime } from "../words";

/** Ticks in a row, from `first` to before `end`. */
export interface Ticks {
  first: number;
  end: number;
}

/** A driver, and the ticks in a row that they drove. */
export interface Turn extends Ticks {
  driver: string;
}

/** Who drove when; one turn if there is one driver. */
export function turns({ episodes }: Pick<Review, "episodes">): Turn[] {
  const result: Turn[] = [];
  for (const { driver, first, end } of episodes) {
    const last = result.at(-1);
    if (last?.driver === driver) last.end = end;
    else result.push({ driver, first, end });
  }
  return result;
}

/** The files that ticks are from. */
export function filesIn({ episodes }: Pick<Review, "episodes">, { first, end }: Ticks): string[] {
  const inside = episodes.filter((each) => each.first < end && first < each.end);
  return [...new Set(inside.map(({ source }) => source))];
}

/** The ticks up to half a second around one, in its episode. */
export function around({ episodes, tick_s }: Pick<Review, "episodes" | "tick_s">, tick: number): Ticks {
  const reach = Math.max(1, Math.round(0.5 / tick_s));
  const inside = episodes.find(({ first, end }) => first <= tick && tick < end);
  return {
    first: Math.max(inside?.first ?? 0, tick - reach),
    end: Math.min(inside?.end ?? tick + 1, tick + reach),
  };
}

const LOST = "The connection to the studio is lost: start it again, and load this page again.";

export class Recording {
  readonly news = new News();
  review: Review | null = null;
  series: RecordedSeries | null = null;
  selected: Ticks | null = null;
  /** The tick under the pointer. */
  pointed: number | null = null;
  busy: Exclude<ReviewRequest["do"], "undo"> | "drive" | "automatic" | null = null;
  error = "";

  async open(): Promise<void> {
    this.series = (await this.fetch("series")) as RecordedSeries | null;
    if (this.series !== null) this.take(await this.fetch("review"));
    this.news.tell();
  }

  /** Show what there is by now, while a person drives; what cannot be had stays as it was. */
  async refresh(): Promise<void> {
    const [series, review] = await Promise.all([this.fetch("series"), this.fetch("review")]);
    if (series === null || review === null) return;
    this.series = series as RecordedSeries;
    this.take(review);
    this.news.tell();
  }

  /** Ask for a change, and show what there is then. */
  async ask(request: ReviewRequest): Promise<void> {
    if (this.busy !== null) return;
    this.busy = request.do === "undo" ? "label" : request.do;
    this.news.tell();
    this.take(await this.fetch("review", request));
    this.busy = null;
    this.news.tell();
  }

  /** Give the selected ticks a label. */
  async label(index: number): Promise<void> {
    const label = this.review?.labels[index];
    if (this.selected === null || label === undefined) return;
    await this.ask({ do: "label", ...this.selected, label });
  }

  select(ticks: Ticks | null): void {
    this.selected = ticks && { first: ticks.first, end: ticks.end };
    this.news.tell();
  }

  point(tick: number | null): void {
    if (tick === this.pointed) return;
    this.pointed = tick;
    this.news.tell();
  }

  /** Select the span after or before the one that is selected; the first one if none is. */
  step(by: 1 | -1): void {
    const spans = this.review?.spans ?? [];
    const at = this.selected === null ? -1 : spans.findIndex(({ end }) => end > (this.selected?.first ?? 0));
    const next = spans[this.selected === null ? 0 : Math.min(spans.length - 1, Math.max(0, at + by))];
    if (next !== undefined) this.select(next);
  }

  get ticks(): number {
    return this.review?.episodes.at(-1)?.end ?? 0;
  }

  spanAt(tick: number): LabelSpan | undefined {
    return this.review?.spans.find(({ first, end }) => first <= tick && tick < end);
  }

  /** The time of a tick in its file, s; of an end, that of the tick before it and a tick more. */
  time(tick: number, isEnd = false): number {
    const { episodes, tick_s } = this.review ?? { episodes: [], tick_s: 0 };
    const inside = isEnd ? tick - 1 : tick;
    const episode = episodes.find(({ first, end }) => first <= inside && inside < end);
    return episode === undefined ? 0 : episode.from_s + (tick - episode.first) * tick_s;
  }

  /** From when to when ticks are. */
  period({ first, end }: Ticks): string {
    return `${formatTime(this.time(first))} to ${formatTime(this.time(end, true))}`;
  }

  private take(result: unknown): void {
    if (result !== null) this.review = result as Review;
  }

  private async fetch(path: string, request?: ReviewRequest): Promise<unknown> {
    const sent = request === undefined ? {} : { method: "POST", body: JSON.stringify(request) };
    try {
      const answer = await fetch(serverAddress(path), sent);
      const result = (await answer.json()) as { error?: string };
      this.error = result.error ?? "";
      return answer.ok ? result : null;
    } catch {
      this.error = LOST;
      return null;
    }
  }
}
