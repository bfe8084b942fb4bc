/** The library as a zip: out as a download, and in again, where nothing is replaced without a question. */

import { useRef, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { Prompt } from "../confirm";
import { useStudio } from "../context";
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
          onClick={() => downloadLibrary(studio)}
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
  const address = studio.address(PATH);
  address.searchParams.set("conflicts", conflicts);
  try {
    const answer = await fetch(address, { method: "POST", body: file });
    return (await answer.json()) as ImportAnswer;
  } catch {
    return { error: `${file.name} could not be sent: the studio does not answer, or the file is gone.` };
  }
}

function downloadLibrary(studio: Studio): void {
  const link = document.createElement("a");
  link.href = studio.address(PATH).href;
  link.download = PATH;
  link.click();
}
