/** Questions in place, never over the running world: in place of a button, and before something is left behind. */

import { Button } from "./button";
import type { ComponentChildren } from "preact";

interface ConfirmProps {
  /** What would happen. */
  children: ComponentChildren;
  /** The label of the button that lets it happen. */
  label: string;
  disabled?: boolean;
  onConfirm: () => void;
  /** Take the question away; called with either answer. */
  onClose: () => void;
}

export function Confirm({ children, label, disabled = false, onConfirm, onClose }: ConfirmProps) {
  return (
    <>
      {children}
      <Button
        class="primary"
        disabled={disabled}
        onClick={() => {
          onClose();
          onConfirm();
        }}
      >
        {label}
      </Button>
      <Button onClick={onClose}>Cancel</Button>
    </>
  );
}

interface PromptProps {
  children: ComponentChildren;
  /** What each answer does, by the words on its button. */
  answers: Readonly<Record<string, () => void>>;
  /** Take the question away, where that is an answer, too. */
  onClose?: () => void;
}

export function Prompt({ children, answers, onClose }: PromptProps) {
  return (
    <div class="prompt" role="alert">
      <p>{children}</p>
      {Object.entries(answers).map(([answer, act]) => (
        <Button key={answer} class="small" onClick={act}>
          {answer}
        </Button>
      ))}
      {onClose !== undefined && (
        <Button class="link" onClick={onClose}>
          not now
        </Button>
      )}
    </div>
  );
}
