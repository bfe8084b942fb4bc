/** Where the food is, in worlds where food is brought home. */

import { useStudio } from "../context";
import type { Frame } from "../frame";
import { useSlowNews } from "../news";
import type { Scene } from "../protocol";

export function Food() {
  const studio = useStudio();
  useSlowNews(studio.framed);
  const { scene, motion } = studio;
  if (scene === null || motion.last === null || !isForaged(scene)) return null;
  const carried = motion.last.robots.stored.reduce((sum, stored) => sum + stored, 0);
  return (
    <section>
      <h2>Food</h2>
      <p class="tiny list">
        <b class="number">{motion.last.delivered}</b> at home, <b class="number">{carried}</b> carried,{" "}
        <b class="number">{countLeft(scene, motion.last)}</b> left
      </p>
    </section>
  );
}

function isForaged(scene: Scene): boolean {
  return scene.classes.some(({ food }) => food) && scene.classes.some(({ home }) => home);
}

function countLeft(scene: Scene, { things }: Frame): number {
  return things.amount.reduce((sum, amount, thing) => {
    return scene.classes[things.kind[thing] ?? -1]?.food === true ? sum + amount : sum;
  }, 0);
}
