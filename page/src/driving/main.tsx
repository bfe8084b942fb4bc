/** The page on which a person drives a robot begins here. */

import { render } from "preact";
import "../style/base.css";
import "../style/recording.css";
import "../style/driving.css";
import { DriveController } from "./driving";
import { DrivePage } from "./page";

const driving = new DriveController();
const root = document.getElementById("app");
if (root !== null) render(<DrivePage driving={driving} />, root);
driving.open();
