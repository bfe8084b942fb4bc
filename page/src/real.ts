/** What the page and the server say to each other of real robots. */

export type RealRequest =
  | { do: "arm" | "stop" }
  | { do: "here"; holding: boolean }
  | {
      do: "pick_color";
      robot: number;
      name: string;
      image: number;
      points: readonly (readonly [number, number])[];
    };

export interface RealScene {
  /** The names of the robots, where they are real. */
  real: readonly string[];
  /** The numbers of those that have a camera. */
  eyes: readonly number[];
  /** Whether they move only while a key is held. */
  holds: boolean;
}

/** A real robot: whether it may move, and why it does not. */
export interface RobotNews {
  name: string;
  armed: boolean;
  stopped: string;
}
