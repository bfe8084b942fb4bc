/** What the pages of a recording and of a drive share: their bar, and buttons about what is reviewed. */

import type { ButtonHTMLAttributes, ComponentChildren } from "preact";
import { Button } from "../button";
import type { Review, ReviewRequest } from "../protocol";
import { plain } from "../words";
import type { Recording } from "./recording";
import { swatch } from "./scale";

interface BarProps {
  title: ComponentChildren;
  /** What went wrong, in a line of its own; empty while nothing does. */
  error: string;
  children: ComponentChildren;
}

export function Bar({ title, error, children }: BarProps) {
  return (
    <>
      <header class="flex bar">
        <h1 class="logo">Understudy</h1>
        <span class="divider" />
        <b class="cut">{title}</b>
        {children}
      </header>
      {error !== "" && (
        <p class="error" role="alert">
          {error}
        </p>
      )}
    </>
  );
}

type ReviewButtonProps = ButtonHTMLAttributes<HTMLButtonElement> & {
  recording: Recording;
  /** What a click asks for; without one, it submits a form. */
  request?: ReviewRequest;
};

/** A button that changes the review: disabled while another change is under way. */
export function ReviewButton({ recording, request, disabled = false, ...rest }: ReviewButtonProps) {
  return (
    <Button
      type={request === undefined ? "submit" : "button"}
      {...rest}
      disabled={disabled || recording.busy !== null}
      onClick={() => void (request !== undefined && recording.ask(request))}
    />
  );
}

export function Swatch({ label, review }: { label: number; review: Review }) {
  return <span class="swatch" style={{ background: swatch(label, review.labels.length) }} />;
}

/** The name of a label; the last one is of no behavior. */
export function nameLabel({ labels }: Review, label: number, none = "none of these"): string {
  return label === labels.length - 1 ? none : plain(labels[label] ?? "");
}
