/** Buttons: any, and those that change the session. */

import type { ButtonHTMLAttributes } from "preact";
import { useStudio } from "./context";
import type { Request } from "./protocol";

type ButtonProps = ButtonHTMLAttributes<HTMLButtonElement>;

/** A button that submits no form. */
export function Button(props: ButtonProps) {
  return <button type="button" {...props} />;
}

/** A cross that takes something away; its label says what. */
export function CloseButton({ label, ...rest }: ButtonProps & { label: string }) {
  return (
    <Button aria-label={label} {...rest}>
      ×
    </Button>
  );
}

interface ControlButtonProps extends ButtonProps {
  /** What a click asks of the server; `onClick` says what else it does. */
  request?: Request;
  /** The request that takes it back, which is offered beside the answer. */
  back?: Request;
}

/** A button that is disabled on a page without control of the session. */
export function ControlButton({ request, back, disabled = false, onClick, ...rest }: ControlButtonProps) {
  const studio = useStudio();
  const ask = () => {
    if (request === undefined) return;
    void (back === undefined ? studio.ask(request) : studio.change(request, back));
  };
  return (
    <Button
      {...rest}
      disabled={disabled || !studio.hasControl}
      onClick={request === undefined ? onClick : ask}
    />
  );
}
