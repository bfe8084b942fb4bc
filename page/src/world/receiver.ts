/** What the server shows of a world: frames, or pictures that a body of one's own draws of itself. */

import { decode, pictureIn, type Frame } from "../frame";
import { News } from "../news";
import { Motion } from "./motion";

export abstract class FrameReceiver {
  /** Anything but frames. */
  readonly news = new News();
  readonly framed = new News();
  readonly motion = new Motion();
  /** The newest picture. */
  image: ImageBitmap | null = null;
  private pictures = 0;
  private pictureShown = 0;

  receiveFrame(buffer: ArrayBuffer): void {
    const picture = pictureIn(buffer);
    if (picture !== null) {
      void this.showPicture(picture);
      return;
    }
    const frame = decode(buffer);
    this.motion.take(frame);
    this.keepFrame(frame);
    this.framed.tell();
  }

  /** Keep what is needed of a frame beside where everything is. */
  protected abstract keepFrame(frame: Frame): void;

  /** Show a picture, unless a newer one came while this one was decoded. */
  private async showPicture(picture: Blob): Promise<void> {
    this.pictures += 1;
    const number = this.pictures;
    const image = await createImageBitmap(picture);
    if (number < this.pictureShown) return;
    this.pictureShown = number;
    this.image?.close();
    this.image = image;
    this.framed.tell();
  }
}
