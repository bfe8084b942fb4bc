/** Drawing once in a screen frame, however many reasons there are for it, and never while the page is hidden. */

export class Redraw {
  private asked = 0;
  private due = false;

  constructor(private readonly draw: () => void) {
    document.addEventListener("visibilitychange", this.catchUp);
  }

  /** Draw with the next screen frame; if the page is hidden, with the first one after it is shown. */
  ask(): void {
    this.due = true;
    if (this.asked === 0 && !document.hidden) this.asked = requestAnimationFrame(() => this.run());
  }

  close(): void {
    document.removeEventListener("visibilitychange", this.catchUp);
    cancelAnimationFrame(this.asked);
  }

  private readonly catchUp = (): void => {
    if (this.due) this.ask();
  };

  private run(): void {
    this.asked = 0;
    if (document.hidden) return;
    this.due = false;
    this.draw();
  }
}
