/** The library as a zip: out as a download, and in again, where nothing is replaced without a question. */

import { useRef, useState } from "preact/hooks";
import type { Studio } from "../studio";
import { plain } from "../words";

const PATH = "library.zip";
type Taken = "refuse" | "replace" | "keep";

interface Told {
  said?: string;
  error?: string;
  /** Behaviors that are in the library already, and not the same. */
  taken?: readonly string[];
}

export function Parcel({ studio }: { studio: Studio }) {
  const [asked, setAsked] = useState<{ file: File; taken: readonly string[] } | null>(null);
  const [sending, setSending] = useState(false);
  const field = useRef<HTMLInputElement>(null);
  const { directs, told } = studio;
  const give = async (file: File, taken: Taken): Promise<void> => {
    setAsked(null);
    setSending(true);
    const answer = await sent(studio, file, taken);
    setSending(false);
    if (answer.taken !== undefined) setAsked({ file, taken: answer.taken });
    else if (answer.error !== undefined) studio.say({ text: answer.error, tone: "error" });
  };
  return (
    <>
      <p class="padded parcel">
        <button
          type="button"
          disabled={told === null || told.library.trained.length === 0}
          onClick={() => fetchTo(studio)}
        >
          Export library
        </button>
        <button type="button" disabled={!directs || sending} onClick={() => field.current?.click()}>
          Import…
        </button>
        <input
          ref={field}
          type="file"
          accept=".zip,application/zip"
          hidden
          aria-label="A library as a zip"
          onChange={(event) => {
            const file = event.currentTarget.files?.[0];
            event.currentTarget.value = "";
            if (file !== undefined) void give(file, "refuse");
          }}
        />
      </p>
      {asked !== null && (
        <div class="asks" role="alert">
          <p>
            {asked.taken.map(plain).join(", ")} {asked.taken.length === 1 ? "is" : "are"} in the library
            already, and not the same. What is replaced is kept as a former version.
          </p>
          <button type="button" class="small" onClick={() => void give(asked.file, "replace")}>
            Replace
          </button>
          <button type="button" class="small" onClick={() => void give(asked.file, "keep")}>
            Import only the others
          </button>
          <button type="button" class="link" onClick={() => setAsked(null)}>
            not now
          </button>
        </div>
      )}
    </>
  );
}

async function sent(studio: Studio, file: File, taken: Taken): Promise<Told> {
  const address = studio.address(PATH);
  address.searchParams.set("taken", taken);
  try {
    const answer = await fetch(address, { method: "POST", body: file });
    return (await answer.json()) as Told;
  } catch {
    return { error: `${file.name} could not be sent: the studio does not answer, or the file is gone.` };
  }
}

function fetchTo(studio: Studio): void {
  const link = document.createElement("a");
  link.href = studio.address(PATH).href;
  link.download = PATH;
  link.click();
}
