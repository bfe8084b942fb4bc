/** The page on which a person drives a robot begins here. */

import { render } from "preact";
import "../style/base.css";
import "../style/recording.css";
import "../style/driving.css";
import { Driving } from "./driving";
import { DrivingPage } from "./page";

const driving = new Driving();
const root = document.getElementById("app");
if (root !== null) render(<DrivingPage driving={driving} />, root);
driving.open();
