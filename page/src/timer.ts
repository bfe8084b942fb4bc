/** A timer that runs only as long as it is wanted. */

/** Call `act` every `ms` while the timer is on; return what turns it on and off. */
export function makeTimer(act: () => void, ms: number): (on: boolean) => void {
  let timer: ReturnType<typeof setInterval> | undefined;
  return (on) => {
    if (on) timer ??= setInterval(act, ms);
    else {
      clearInterval(timer);
      timer = undefined;
    }
  };
}
