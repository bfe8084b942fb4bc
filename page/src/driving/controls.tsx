/** The stick on the page, the behaviors that are held as buttons, and the label of the moment. */

import { useRef } from "preact/hooks";
import { Button } from "../button";
import { KeyName } from "../keyname";
import { useNews } from "../news";
import { nameLabel, Swatch } from "../recording/label";
import { className, hasKeys, plain } from "../words";
import type { DriveController } from "./driving";
import type { Arrow } from "../protocol";
import { HOLDS, readPointer, maskLean } from "./stick";

const SIGNS: Readonly<Record<Arrow, string>> = { up: "▲", down: "▼", left: "◀", right: "▶" };

/** How far the knob goes from the middle, as a share of the size of the stick. */
const REACH = 0.3;

export function Controls({ driving }: { driving: DriveController }) {
  useNews(driving.moved);
  const held = driving.status?.held ?? [];
  const now = new Set(driving.stick.listHeld(held.length));
  return (
    <section class="flex controls" aria-label="Driving">
      <StickPad driving={driving} />
      <div class="held">
        {held.map((name, index) => (
          <Button
            key={name}
            aria-pressed={now.has(index)}
            class={className("flex", now.has(index) && "on")}
            onPointerDown={(event) => {
              event.currentTarget.setPointerCapture(event.pointerId);
              driving.begin();
              driving.stick.pushed.add(index);
              driving.steer();
            }}
            onLostPointerCapture={() => {
              driving.stick.pushed.delete(index);
              driving.steer();
            }}
            onContextMenu={(event) => event.preventDefault()}
          >
            <span class="cut">{plain(name)}</span>
            {hasKeys() && HOLDS[index] !== undefined && <KeyName place={HOLDS[index]} />}
          </Button>
        ))}
        <Moment driving={driving} />
      </div>
    </section>
  );
}

function StickPad({ driving }: { driving: DriveController }) {
  const pad = useRef<HTMLDivElement>(null);
  const { lean } = driving.stick;
  const ways = driving.status?.directions ?? [];
  const pull = (event: PointerEvent): void => {
    const box = pad.current?.getBoundingClientRect();
    if (box === undefined) return;
    const [x, y] = [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
    const { right, up } = readPointer(x, y, box.width * REACH);
    driving.stick.pulled = maskLean({ right, up }, ways);
    driving.steer();
  };
  const release = (): void => {
    driving.stick.pulled = null;
    driving.steer();
  };
  return (
    <div
      ref={pad}
      class={className("stick", driving.stick.pulled !== null && "grasped")}
      role="img"
      aria-label="Stick: drag it to drive, or use the arrow keys"
      onPointerDown={(event) => {
        event.preventDefault();
        if (event.button !== 0) return;
        (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
        driving.begin();
        pull(event);
      }}
      onPointerMove={(event) => driving.stick.pulled !== null && pull(event)}
      onLostPointerCapture={release}
    >
      {ways.map((way) => (
        <span key={way} class={className("way", way)}>
          {SIGNS[way]}
        </span>
      ))}
      <span
        class="knob"
        style={{ left: `${50 + 100 * REACH * lean.right}%`, top: `${50 - 100 * REACH * lean.up}%` }}
      />
    </div>
  );
}

/** What the drive is at this moment, as far as it is known. */
function Moment({ driving }: { driving: DriveController }) {
  const { review } = driving.recording;
  const last = review?.spans.at(-1);
  if (driving.automatic)
    return (
      <p class="flex moment" role="status">
        <span>
          By itself: <b>{plain(driving.status?.state ?? "")}</b>. Move the stick to take over.
        </span>
      </p>
    );
  if (driving.status?.waiting === true)
    return <p class="flex moment soft">Move the stick: the world waits for you.</p>;
  if (!driving.driving || last === undefined || review === null) return null;
  return (
    <p class="flex moment" role="status">
      <Swatch label={last.label} review={review} />
      {nameLabel(review, last.label, "no behavior explains this")}
    </p>
  );
}
