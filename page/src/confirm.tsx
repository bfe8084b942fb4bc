/** A question in place of a button: what would happen, and the two answers. */

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
