/** What a real robot's camera sees, and teaching it a color by clicking on a thing. */

import { useEffect, useRef, useState } from "preact/hooks";
import { Button } from "./button";
import { useStudio } from "./context";
import { Select } from "./fields";
import type { Studio } from "./studio";
import { className } from "./words";

const EVERY_MS = 200;
const NUMBER = "X-Image";

interface CameraImage {
  url: string;
  number: number;
}

type Point = readonly [number, number];

export function CameraView() {
  const studio = useStudio();
  const [open, setOpen] = useState(true);
  const eyes = studio.scene?.camera_robots ?? [];
  const trained = studio.session?.agent ?? 0;
  const robot = eyes.includes(trained) ? trained : eyes[0];
  if (robot === undefined) return null;
  return (
    <section class="camera" aria-label="Camera">
      <Button class="fold" aria-expanded={open} onClick={() => setOpen(!open)}>
        Camera{eyes.length > 1 && ` of ${studio.scene?.real_robots[robot] ?? ""}`}
      </Button>
      {open && <Picture key={robot} robot={robot} />}
    </section>
  );
}

function Picture({ robot }: { robot: number }) {
  const studio = useStudio();
  const image = useImages(studio, robot);
  const [name, setName] = useState(studio.scene?.targets[0] ?? "");
  const [points, setPoints] = useState<readonly Point[]>([]);
  const into = useRef<number | null>(null);

  const choose = (next: string): void => {
    setName(next);
    setPoints([]);
  };
  const click = async (event: MouseEvent): Promise<void> => {
    const element = event.currentTarget as HTMLImageElement;
    if (image === null || !studio.hasControl) return;
    const box = element.getBoundingClientRect();
    const at: Point = [
      Math.floor(((event.clientX - box.left) / box.width) * element.naturalWidth),
      Math.floor(((event.clientY - box.top) / box.height) * element.naturalHeight),
    ];
    // Clicks count together as long as they are into one image: the robot stands, or the thing is clicked again.
    const all = into.current === image.number ? [...points, at] : [at];
    into.current = image.number;
    setPoints(all);
    await studio.ask({ do: "pick_color", robot, name, image: image.number, points: all });
  };

  return (
    <>
      {image === null ? (
        <p class="soft">No image has come yet.</p>
      ) : (
        <img
          src={image.url}
          class={className("seen", studio.hasControl && "picks")}
          alt="What the camera sees, with outlines around the colors it looks for"
          onClick={(event) => void click(event)}
        />
      )}
      {studio.hasControl && (
        <label class="soft">
          Click on the <Select value={name} among={studio.scene?.targets ?? []} change={choose} /> to show its
          color
        </label>
      )}
    </>
  );
}

/** The newest image, several times a second. */
function useImages(studio: Studio, robot: number): CameraImage | null {
  const [image, setImage] = useState<CameraImage | null>(null);
  useEffect(() => {
    let going = true;
    let last: string | null = null;
    const take = async (): Promise<void> => {
      try {
        const answer = await studio.fetch(`camera/${robot}.jpg`);
        if (going && answer.status === 200) {
          const url = URL.createObjectURL(await answer.blob());
          setImage({ url, number: Number(answer.headers.get(NUMBER)) });
          if (last !== null) URL.revokeObjectURL(last);
          last = url;
        }
      } catch {
        // The connection is lost, which the page says elsewhere.
      }
    };
    const look = async (): Promise<void> => {
      if (!document.hidden) await take();
      if (going) setTimeout(() => void look(), EVERY_MS);
    };
    void look();
    return () => {
      going = false;
      if (last !== null) URL.revokeObjectURL(last);
    };
  }, [studio, robot]);
  return image;
}
