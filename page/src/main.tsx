/** The page begins here. */

import { render } from "preact";
import { App } from "./app";
import { Panel } from "./panel";
import { Studio } from "./studio";
import { Tour } from "./tour";
import "./style/base.css";
import "./style/header.css";
import "./style/side.css";
import "./style/world.css";
import "./style/grid.css";
import "./style/panel.css";
import "./style/coach.css";
import "./style/review.css";
import "./style/tour.css";
import "./style/team.css";
import "./style/touch.css";
import "./style/narrow.css";

const studio = new Studio();
const root = document.getElementById("app");
if (root !== null) render(<App studio={studio} panel={new Panel()} tour={new Tour(localStorage)} />, root);
studio.open();
