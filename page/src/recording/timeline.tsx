/** The timeline: labels, what the learned automaton does, commands and readings, tick by tick. */

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { Button } from "../button";
import type { Review, Series } from "../protocol";
import { className, formatTime, plain, formatValue } from "../words";
import { filesIn, turns, type Recording, type Ticks } from "./recording";
import { color, lines, marks } from "./scale";

const NAMES = 130;
const LABELS = 40;
const STATES = 22;
const SERIES = 46;
const AXIS = 22;
/** The lane that shows the driver, where there are several drivers. */
const DRIVERS = 22;
/** How near to a boundary it is taken hold of, px. */
const REACH = 6;
const ZOOM = 1.6;
const MOST_ZOOM = 40;
/** The width of a letter of a label, about, px. */
const LETTER = 7.4;
/** What is shown while a person drives, s. */
const LIVE_S = 20;

interface TimelineProps {
  recording: Recording;
  review: Review;
  series: readonly Series[];
  /** Whether a person drives: its end is shown then, at one scale. */
  live?: boolean;
}

/** What the pointer is doing: moving a boundary, or selecting ticks. */
type Drag = { kind: "boundary"; at: number; now: number } | { kind: "range"; from: number; now: number };

export function TimelineView({ recording, review, series, live = false }: TimelineProps) {
  const place = useRef<HTMLDivElement>(null);
  const [room, setRoom] = useState(800);
  const [zoom, setZoom] = useState(1);
  const [drag, setDrag] = useState<Drag | null>(null);
  const ticks = recording.ticks;
  useLayoutEffect(() => {
    const element = place.current;
    if (element === null) return;
    const watch = new ResizeObserver(() => setRoom(element.clientWidth));
    watch.observe(element);
    return () => watch.disconnect();
  }, []);
  const shortest = live ? LIVE_S / review.tick_s : 1;
  const width = Math.max(1, room * (live ? Math.max(1, ticks / shortest) : zoom));
  const tickWidth = width / Math.max(shortest, ticks);
  useLayoutEffect(() => {
    if (live && place.current !== null) place.current.scrollLeft = width;
  }, [live, width]);
  useLayoutEffect(() => {
    const { selected } = recording;
    const element = place.current;
    if (selected === null || element === null) return;
    const [left, right] = [selected.first * tickWidth, selected.end * tickWidth];
    if (right < element.scrollLeft || left > element.scrollLeft + element.clientWidth) {
      element.scrollLeft = (left + right) / 2 - element.clientWidth / 2;
    }
  }, [recording.selected, tickWidth]);
  const enlarge = (factor: number): void => {
    const element = place.current;
    const next = Math.min(MOST_ZOOM, Math.max(1, zoom * factor));
    setZoom(next);
    if (element === null) return;
    const center = (element.scrollLeft + element.clientWidth / 2) * (next / zoom);
    requestAnimationFrame(() => (element.scrollLeft = center - element.clientWidth / 2));
  };
  const { learned, labels, spans } = review;
  const drives = turns(review);
  const top = AXIS + (drives.length > 1 ? DRIVERS : 0);
  const lanesTop = top + LABELS + (learned === null ? 0 : STATES + 4) + 6;
  const height = lanesTop + series.length * SERIES;
  /** A line at a tick, from a height to the bottom. */
  const lineAt = (tick: number, y: number, name?: string) => (
    <line class={name} x1={tick * tickWidth} x2={tick * tickWidth} y1={y} y2={height} />
  );
  /** A box as wide as ticks in a row, with room after it. */
  const box = (
    { first, end }: Ticks,
    y: number,
    height: number,
    { gap = 1, least = 1, ...rest }: { gap?: number; least?: number; class?: string; fill?: string } = {},
  ) => (
    <rect
      x={first * tickWidth}
      y={y}
      width={Math.max(least, (end - first) * tickWidth - gap)}
      height={height}
      {...rest}
    />
  );
  const tickAt = (event: PointerEvent): number => {
    const box = (event.currentTarget as SVGElement).getBoundingClientRect();
    return Math.min(ticks, Math.max(0, Math.round((event.clientX - box.left) / tickWidth)));
  };

  const take = (event: PointerEvent): void => {
    if (event.button !== 0 || recording.busy !== null) return;
    (event.currentTarget as SVGElement).setPointerCapture(event.pointerId);
    const tick = tickAt(event);
    const at = nearBoundary(review, tick, REACH / tickWidth);
    setDrag(at === null ? { kind: "range", from: tick, now: tick } : { kind: "boundary", at, now: at });
  };
  const move = (event: PointerEvent): void => {
    const tick = tickAt(event);
    recording.point(Math.min(tick, ticks - 1));
    if (drag === null) return;
    if (drag.kind === "boundary") setDrag({ ...drag, now: clampBoundary(review, drag.at, tick) });
    else setDrag({ ...drag, now: clampToEpisode(review, drag.from, tick) });
  };
  const release = (event: PointerEvent): void => {
    if (drag === null) return;
    setDrag(null);
    if (drag.kind === "boundary") {
      const request = moveBoundary(review, drag.at, drag.now);
      if (request !== null) void recording.ask(request);
    } else if (Math.abs(drag.now - drag.from) * tickWidth < REACH) {
      const span = recording.spanAt(Math.min(tickAt(event), ticks - 1));
      if (span !== undefined) recording.select(span);
    } else {
      recording.select(orderTicks(drag.from, drag.now));
    }
  };
  const span = drag?.kind === "range" ? orderTicks(drag.from, drag.now) : recording.selected;

  return (
    <section class="timeline-view" aria-label="Timeline">
      <div class="flex tools">
        <span class="tiny soft">
          {live
            ? "What explains your commands, about a second after you gave them. Pause to change labels."
            : "Click a span to select it, drag across the labels to select a part, drag a boundary to move it."}
        </span>
        <span class="space" />
        {!live && (
          <>
            <Button aria-label="Zoom out" onClick={() => enlarge(1 / ZOOM)}>
              −
            </Button>
            <Button aria-label="Zoom in" onClick={() => enlarge(ZOOM)}>
              +
            </Button>
          </>
        )}
      </div>
      <div class="lanes" tabIndex={0} role="group" aria-label="Labels, commands and readings">
        <div class="lane-names" style={{ width: px(NAMES) }}>
          <div style={{ height: px(AXIS) }} />
          {drives.length > 1 && <div style={{ height: px(DRIVERS) }}>driver</div>}
          <div style={{ height: px(LABELS) }}>labels</div>
          {learned !== null && <div style={{ height: px(STATES + 4) }}>learned</div>}
          <div style={{ height: px(6) }} />
          {series.map((each) => (
            <div
              key={each.label}
              style={{ height: px(SERIES) }}
              class={className(each.is_command && "command")}
            >
              <span class="cut" title={each.label}>
                {plain(each.label)}
              </span>
              <b>{valueAt(each, recording.pointed ?? (live ? ticks - 1 : null))}</b>
            </div>
          ))}
        </div>
        <div class="scroll" ref={place}>
          <svg
            width={width}
            height={height}
            class={className("strip", drag?.kind === "boundary" && "moving")}
            role="group"
            aria-label="Labels over time"
            onPointerDown={take}
            onPointerMove={move}
            onPointerUp={release}
            onPointerLeave={() => recording.point(null)}
          >
            <defs>
              <pattern
                id="none"
                width="6"
                height="6"
                patternUnits="userSpaceOnUse"
                patternTransform="rotate(45)"
              >
                <rect width="6" height="6" class="none-ground" />
                <rect width="2" height="6" class="none-line" />
              </pattern>
            </defs>
            {review.episodes.map((episode) => (
              <g key={episode.first}>
                {marks(episode, review.tick_s, tickWidth).map(({ tick, time }) => (
                  <g key={tick} class="mark">
                    {lineAt(tick, AXIS - 5)}
                    <text x={tick * tickWidth + 3} y={AXIS - 8}>
                      {formatTime(time)}
                    </text>
                  </g>
                ))}
                {episode.first > 0 && lineAt(episode.first, 0, "gap")}
              </g>
            ))}
            {drives.length > 1 &&
              drives.map(({ driver, first, end }) => (
                <g key={first} class="driver" data-driver={driver}>
                  <title>{`${driver}, ${filesIn(review, { first, end }).join(", ")}`}</title>
                  {box({ first, end }, AXIS, DRIVERS - 3)}
                  <text x={first * tickWidth + 6} y={AXIS + DRIVERS - 8}>
                    {fitText(driver, (end - first) * tickWidth - 12)}
                  </text>
                </g>
              ))}
            {spans.map((span) => (
              <g
                key={span.first}
                class={className("span", span.doubtful && "doubtful")}
                data-label={labels[span.label]}
                data-first={span.first}
              >
                <title>
                  {`${plain(labels[span.label] ?? "")}, ${recording.period(span)}, ` +
                    (span.by_hand ? "by hand" : `${(100 * span.certainty).toFixed(0)} % certain`)}
                </title>
                {box(span, top, LABELS, { fill: color(span.label, labels.length) })}
                {span.by_hand && box(span, top + LABELS - 4, 4, { class: "hand" })}
                <SpanLabel
                  span={span}
                  text={plain(labels[span.label] ?? "")}
                  tickWidth={tickWidth}
                  top={top}
                />
                {span.doubtful && (
                  <text class="ask" x={((span.first + span.end) / 2) * tickWidth} y={top + LABELS - 6}>
                    ?
                  </text>
                )}
              </g>
            ))}
            {learned?.spans.map((span) => (
              <g key={`learned ${span.first}`}>
                {box(span, top + LABELS + 4, STATES - 6, { gap: 0, fill: color(span.label, labels.length) })}
              </g>
            ))}
            {learned !== null &&
              differences(review).map((ticks) => (
                <g key={`differs ${ticks.first}`}>
                  {box(ticks, top + LABELS + STATES - 1, 3, { gap: 0, least: 1.5, class: "differs" })}
                </g>
              ))}
            {series.map((each, index) => (
              <SeriesLane
                key={each.label}
                series={each}
                top={lanesTop + index * SERIES}
                scale={tickWidth}
                width={width}
              />
            ))}
            {span !== null && box(span, top, height - top, { class: "selected" })}
            {drag?.kind === "boundary" && lineAt(drag.now, top, "boundary")}
            {recording.pointed !== null && lineAt(recording.pointed, top, "pointed")}
          </svg>
        </div>
      </div>
    </section>
  );
}

interface SpanLabelProps {
  span: Ticks;
  text: string;
  tickWidth: number;
  top: number;
}

/** The label of a span, where it has room. */
function SpanLabel({ span, text, tickWidth, top }: SpanLabelProps) {
  if ((span.end - span.first) * tickWidth < text.length * LETTER + 12) return null;
  return (
    <text class="name" x={span.first * tickWidth + 6} y={top + LABELS / 2 + 4}>
      {text}
    </text>
  );
}

/** A name, shortened to a width in pixels. */
function fitText(name: string, room: number): string {
  const letters = Math.max(0, Math.floor(room / LETTER));
  return name.length <= letters ? name : letters < 2 ? "" : `${name.slice(0, letters - 1)}…`;
}

interface LaneProps {
  series: Series;
  top: number;
  scale: number;
  width: number;
}

function SeriesLane({ series, top, scale, width }: LaneProps) {
  const numbers = series.values.filter((value) => value !== null);
  const least = Math.min(...numbers, series.is_command ? 0 : Infinity);
  const most = Math.max(...numbers, series.is_command ? 0 : -Infinity);
  const flat = most - least < 1e-9;
  const zero = least < 0 && most > 0 ? top + 5 + (1 - -least / (most - least)) * (SERIES - 12) : null;
  return (
    <g class={className("lane", series.is_command && "command")}>
      <line class="under" x1={0} x2={width} y1={top + SERIES - 1} y2={top + SERIES - 1} />
      {zero !== null && <line class="zero" x1={0} x2={width} y1={zero} y2={zero} />}
      {lines(series, flat ? least - 1 : least, flat ? most + 1 : most).map((points) => (
        <polyline
          key={points.slice(0, 20)}
          points={points}
          transform={`translate(0 ${top + 5}) scale(${scale} ${SERIES - 12})`}
          vector-effect="non-scaling-stroke"
        />
      ))}
    </g>
  );
}

/** The ticks at which the learned automaton is in another state than that of the label. */
export function differences({ learned, spans, labels }: Review): Ticks[] {
  const gaps: Ticks[] = [];
  for (const state of learned?.spans ?? []) {
    for (const span of spans) {
      const [first, end] = [Math.max(state.first, span.first), Math.min(state.end, span.end)];
      if (first >= end || state.label === span.label || span.label === labels.length - 1) continue;
      const last = gaps.at(-1);
      if (last !== undefined && last.end === first) last.end = end;
      else gaps.push({ first, end });
    }
  }
  return gaps;
}

/** The value of a series at a tick, in words. */
function valueAt(series: Series, tick: number | null): string {
  if (tick === null) return "";
  const step = (series.ticks[1] ?? 1) - (series.ticks[0] ?? 0);
  const gaps = series.values[Math.min(series.values.length - 1, Math.floor(tick / Math.max(1, step)))];
  return formatValue(series, gaps ?? NaN);
}

function px(length: number): string {
  return `${length}px`;
}

/** The boundary between two spans of one episode that is nearest to a tick, if it is near enough. */
function nearBoundary(review: Review, tick: number, reach: number): number | null {
  const starts = new Set(review.episodes.map(({ first }) => first));
  const near = review.spans
    .map(({ first }) => first)
    .filter((first) => !starts.has(first) && Math.abs(first - tick) <= reach);
  return near.sort((one, other) => Math.abs(one - tick) - Math.abs(other - tick))[0] ?? null;
}

/** Where a boundary may go: between the beginning of the span before it and the end of that after it. */
function clampBoundary(review: Review, at: number, tick: number): number {
  const index = review.spans.findIndex(({ first }) => first === at);
  const [before, after] = [review.spans[index - 1], review.spans[index]];
  if (before === undefined || after === undefined) return at;
  return Math.min(after.end, Math.max(before.first, tick));
}

/** A tick in the same episode as another one. */
function clampToEpisode(review: Review, from: number, tick: number): number {
  const episode =
    review.episodes.find(({ first, end }) => first <= from && from < end) ?? review.episodes.at(-1);
  return episode === undefined ? tick : Math.min(episode.end, Math.max(episode.first, tick));
}

/** What moving a boundary means: the ticks between get the label of the span that grew. */
export function moveBoundary(
  review: Review,
  at: number,
  to: number,
): { do: "label"; first: number; end: number; label: string } | null {
  const index = review.spans.findIndex(({ first }) => first === at);
  const grown = review.spans[to < at ? index : index - 1];
  const label = grown === undefined ? undefined : review.labels[grown.label];
  if (to === at || label === undefined) return null;
  return { do: "label", ...orderTicks(at, to), label };
}

function orderTicks(one: number, other: number): Ticks {
  return { first: Math.min(one, other), end: Math.max(one, other) };
}
