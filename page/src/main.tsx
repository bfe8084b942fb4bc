/** The page begins here. */

import { render } from "preact";
import { App } from "./app";
import { Panel } from "./panel";
import { Studio } from "./studio";
import "./style/base.css";
import "./style/header.css";
import "./style/side.css";
import "./style/world.css";
import "./style/panel.css";

const studio = new Studio();
const root = document.getElementById("app");
if (root !== null) render(<App studio={studio} panel={new Panel()} />, root);
studio.open();
