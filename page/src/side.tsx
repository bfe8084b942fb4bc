/** The left column: robots, library, parameters, food, features now, what a camera sees. */

import { CameraView } from "./camera";
import { ResumeTour } from "./guide";
import { Food } from "./side/food";
import { Readings } from "./side/readings";
import { RobotList } from "./side/robots";
import { LibraryList } from "./side/library";
import { ParameterList } from "./side/parameters";

export function Side() {
  return (
    <aside class="side" aria-label="Robots, library and features">
      <RobotList />
      <LibraryList />
      <ResumeTour />
      <ParameterList />
      <Food />
      <Readings />
      <CameraView />
    </aside>
  );
}
