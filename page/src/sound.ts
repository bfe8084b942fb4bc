/** The sound of a question: two short notes, off until it is switched on; this browser keeps the choice. */

const KEPT = "understudy-sound";
const NOTES_HZ = [660, 880] as const;
const NOTE_S = 0.12;
const LOUDNESS = 0.15;

/** What was asked so far: the waiting question, and how many moments are marked. */
export interface QuestionState {
  question: string | null;
  marks: number;
}

/** Whether something is asked that was not asked before. */
export function isNewQuestion(now: QuestionState, before: QuestionState): boolean {
  return (now.question !== null && now.question !== before.question) || now.marks > before.marks;
}

export function soundIsOn(store: Pick<Storage, "getItem"> = localStorage): boolean {
  return store.getItem(KEPT) === "on";
}

/** Turn the sound on or off; turned on, it is heard once. */
export function turnSound(on: boolean, store: Pick<Storage, "setItem"> = localStorage): void {
  store.setItem(KEPT, on ? "on" : "off");
  if (on) playQuestion();
}

export function playQuestion(): void {
  const context = new AudioContext();
  const gain = new GainNode(context, { gain: LOUDNESS });
  gain.connect(context.destination);
  NOTES_HZ.forEach((frequency, index) => {
    const note = new OscillatorNode(context, { frequency });
    note.connect(gain);
    note.start(context.currentTime + index * NOTE_S);
    note.stop(context.currentTime + (index + 1) * NOTE_S);
  });
  setTimeout(() => void context.close(), 1000 * (NOTES_HZ.length + 1) * NOTE_S);
}
