/** The library as a zip: out as a download, and in again, where nothing is replaced without a question. */

import { useRef, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { Prompt } from "../confirm";
import { useStudio } from "../context";
import { saveFile } from "../export";
import type { Studio } from "../studio";
import { plain } from "../words";

const PATH = "library.zip";
type ConflictRule = "refuse" | "replace" | "keep";

interface ImportAnswer {
  message?: string;
  error?: string;
  /** Behaviors that are in the library already, and not the same. */
  conflicts?: readonly string[];
}

export function LibraryTransfer() {
  const studio = useStudio();
  const [conflict, setConflict] = useState<{ file: File; conflicts: readonly string[] } | null>(null);
  const [sending, setSending] = useState(false);
  const field = useRef<HTMLInputElement>(null);
  const { status } = studio;
  const importFile = async (file: File, conflicts: ConflictRule): Promise<void> => {
    setConflict(null);
    setSending(true);
    const answer = await sendFile(studio, file, conflicts);
    setSending(false);
    if (answer.conflicts !== undefined) setConflict({ file, conflicts: answer.conflicts });
    else if (answer.error !== undefined) studio.say({ text: answer.error, tone: "error" });
  };
  return (
    <>
      <p class="library-transfer">
        <Button
          disabled={status === null || status.library.trained.length === 0}
          onClick={() => void downloadLibrary(studio)}
        >
          Export library
        </Button>
        <ControlButton disabled={sending} onClick={() => field.current?.click()}>
          Import…
        </ControlButton>
        <input
          ref={field}
          type="file"
          accept=".zip,application/zip"
          hidden
          aria-label="A library as a zip"
          onChange={(event) => {
            const file = event.currentTarget.files?.[0];
            event.currentTarget.value = "";
            if (file !== undefined) void importFile(file, "refuse");
          }}
        />
      </p>
      {studio.storageNote !== "" && <p class="tiny">{studio.storageNote}</p>}
      {conflict !== null && (
        <Prompt
          answers={{
            Replace: () => void importFile(conflict.file, "replace"),
            "Import only the others": () => void importFile(conflict.file, "keep"),
          }}
          onClose={() => setConflict(null)}
        >
          {conflict.conflicts.map(plain).join(", ")} {conflict.conflicts.length === 1 ? "is" : "are"} in the
          library already, and not the same. What is replaced is kept as a former version.
        </Prompt>
      )}
    </>
  );
}

async function sendFile(studio: Studio, file: File, conflicts: ConflictRule): Promise<ImportAnswer> {
  try {
    const answer = await studio.fetch(PATH, {
      query: [["conflicts", conflicts]],
      content: file,
      sends: true,
    });
    return (await answer.json()) as ImportAnswer;
  } catch {
    return { error: `${file.name} could not be sent: the studio does not answer, or the file is gone.` };
  }
}

async function downloadLibrary(studio: Studio): Promise<void> {
  try {
    const answer = await studio.fetch(PATH);
    if (answer.ok) saveFile(await answer.blob(), PATH);
    else studio.say({ text: ((await answer.json()) as ImportAnswer).error ?? "", tone: "error" });
  } catch {
    studio.say({ text: "The library did not arrive: the studio does not answer.", tone: "error" });
  }
}
