/** The bar of the pages of a recording and of a drive, and the buttons that change what is reviewed. */

import type { ButtonHTMLAttributes, ComponentChildren } from "preact";
import { Button } from "../button";
import type { ReviewRequest } from "../protocol";
import type { Recording } from "./recording";

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
