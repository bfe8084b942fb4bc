/** Drawing once in a screen frame, however many reasons there are for it, and never while the page is hidden. */

/** What is drawn in the next screen frame, and the number of that frame's request; 0 without one. */
const waiting = new Set<Redraw>();
let request = 0;

export class Redraw {
  private due = false;

  constructor(private readonly draw: () => void) {
    document.addEventListener("visibilitychange", this.catchUp);
  }

  /** Draw in the next screen frame; if the page is hidden, in the first one after it is shown. */
  ask(): void {
    this.due = true;
    if (document.hidden) return;
    waiting.add(this);
    if (request === 0) request = requestAnimationFrame(drawAll);
  }

  run(): void {
    if (document.hidden) return;
    this.due = false;
    this.draw();
  }

  close(): void {
    document.removeEventListener("visibilitychange", this.catchUp);
    waiting.delete(this);
    if (waiting.size > 0) return;
    cancelAnimationFrame(request);
    request = 0;
  }

  private readonly catchUp = (): void => {
    if (this.due) this.ask();
  };
}

function drawAll(): void {
  request = 0;
  for (const each of [...waiting]) {
    waiting.delete(each); // before it is drawn, which may ask for the next frame, or fail
    each.run();
  }
}
