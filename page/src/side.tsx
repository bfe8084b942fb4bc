/** The left column: robots, library, parameters, food, features now, what a camera sees. */

import { Eye } from "./eye";
import { TakeUp } from "./guide";
import { Food } from "./side/food";
import { Readings } from "./side/readings";
import { Roster } from "./side/roster";
import { Shelf } from "./side/shelf";
import { Standing } from "./side/standing";

export function Side() {
  return (
    <aside class="side" aria-label="Robots, library and features">
      <Roster />
      <Shelf />
      <TakeUp />
      <Standing />
      <Food />
      <Readings />
      <Eye />
    </aside>
  );
}
