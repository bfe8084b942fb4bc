/** A body of one's own: the picture that it draws of itself, or that there is none. */

import { letters, spot, type Picture } from "./picture";

const NONE = "This world draws no picture: teach by the values of its features.";

export function drawBody(picture: Picture, image: ImageBitmap | null): void {
  const { pen, screen, scene, palette } = picture;
  pen.fillStyle = palette.ground;
  pen.fillRect(0, 0, screen.width, screen.height);
  if (scene.drawing === "none") {
    pen.textAlign = "center";
    letters(picture, NONE, screen.width / 2, screen.height / 2, palette.soft);
    pen.textAlign = "start";
    return;
  }
  if (image === null) return;
  const [left, top] = spot(picture, 0, scene.height);
  const [right, bottom] = spot(picture, scene.width, 0);
  pen.imageSmoothingQuality = "high";
  pen.drawImage(image, left, top, right - left, bottom - top);
  pen.strokeStyle = palette.grid;
  pen.lineWidth = 1;
  pen.strokeRect(left, top, right - left, bottom - top);
}
