/** The form that exports a behavior: its target, what its parameters stand for, and a zip as a download. */

import { useRef, useState } from "preact/hooks";
import { Button } from "../button";
import { useStudio } from "../context";
import { exportQuery, fileName, needsRobot, saveFile, targetName, type ExportRequest } from "../export";
import { Field, Form, Option, Select } from "../fields";
import type { TrainedBehavior } from "../protocol";
import type { Studio } from "../studio";

const PATH = "export.zip";
const MESSAGE_HEADER = "X-Understudy-Message";

export function ExportForm({ trained }: { trained: TrainedBehavior }) {
  const studio = useStudio();
  const { name, parameters } = trained;
  const offered = studio.scene?.targets ?? [];
  const [to, setTo] = useState(studio.exports[0]?.name ?? "");
  const [chosen, setChosen] = useState<Record<string, string>>({});
  const [single, setSingle] = useState(false);
  const [robot, setRobot] = useState<File | null>(null);
  const [working, setWorking] = useState(false);
  const field = useRef<HTMLInputElement>(null);
  const targets = Object.fromEntries(parameters.map((each) => [each, chosen[each] ?? offered[0] ?? ""]));
  const real = (studio.status?.robots.length ?? 0) > 0;
  const offersSingle = studio.exports.some((each) => each.name === to && each.single_precision);
  const asksFile = needsRobot(to) && !real;
  const act = async (): Promise<void> => {
    setWorking(true);
    await download(studio, { name, to, targets, single: single && offersSingle }, asksFile ? robot : null);
    setWorking(false);
  };
  return (
    <Form class="export-form" aria-label={`Export ${name}`} submit={() => void (working || act())}>
      <Field label="Export as">
        <Select
          value={to}
          among={studio.exports.map((each) => [each.name, targetName(each.name)])}
          change={setTo}
        />
      </Field>
      {parameters.map((parameter) => (
        <Field key={parameter} label={`${parameter} stands for`}>
          <Select
            value={targets[parameter] ?? ""}
            among={offered}
            change={(target) => setChosen({ ...chosen, [parameter]: target })}
          />
        </Field>
      ))}
      {offersSingle && (
        <Option checked={single} change={setSingle}>
          Single precision, for small microcontrollers
        </Option>
      )}
      {asksFile && (
        <p class="field">
          <span>Robot's file</span>
          <Button class="cut" onClick={() => field.current?.click()}>
            {robot?.name ?? "Choose…"}
          </Button>
          <input
            ref={field}
            type="file"
            accept=".toml"
            hidden
            aria-label="Robot's file"
            onChange={(event) => {
              setRobot(event.currentTarget.files?.[0] ?? robot);
              event.currentTarget.value = ""; // so that the same one can be chosen again, once it was corrected
            }}
          />
        </p>
      )}
      <p class="flex export-foot">
        <button type="submit" class="small" disabled={working || to === "" || (asksFile && robot === null)}>
          {working ? "Exporting…" : "Download"}
        </button>
        <span class="tiny">
          {asksFile && robot === null
            ? "Choose the TOML file that describes the robot."
            : "A zip with a README and a test."}
        </span>
      </p>
    </Form>
  );
}

/** Request the zip file and offer it as a download; show what the export lacks, or why it failed. */
async function download(studio: Studio, wanted: ExportRequest, robot: File | null): Promise<void> {
  const content = await robot?.text().catch(() => null);
  if (content === null) {
    studio.say({ text: `${robot?.name} has changed or is gone: choose it again.`, tone: "error" });
    return;
  }
  try {
    const answer = await studio.fetch(PATH, {
      query: exportQuery(wanted),
      content: content ?? null,
      sends: true,
    });
    if (!answer.ok) {
      const { error } = (await answer.json()) as { error: string };
      studio.say({ text: error, tone: "error" });
      return;
    }
    saveFile(await answer.blob(), fileName(answer.headers.get("Content-Disposition"), PATH));
    studio.say({ text: decodeURIComponent(answer.headers.get(MESSAGE_HEADER) ?? ""), tone: "recorded" });
  } catch {
    studio.say({ text: "The export did not arrive: the studio does not answer.", tone: "error" });
  }
}
