/** The page on which a recording is reviewed begins here. */

import { render } from "preact";
import "../style/base.css";
import "../style/recording.css";
import { RecordingPage } from "./page";
import { Recording } from "./recording";

const recording = new Recording();
const root = document.getElementById("app");
if (root !== null) render(<RecordingPage recording={recording} />, root);
void recording.open();
