/** Pictures with a transparent background, of two that differ in it alone. */

/** Sum of the differences of a pixel's colours, of 255 each, from which on there is any background. */
const LEAST_DIFFERENCE = 200;

/** Returns what a canvas shows, as a picture of its own. */
export function copyOf(canvas: HTMLCanvasElement): HTMLCanvasElement {
  const copy = blank(canvas.width, canvas.height);
  copy.getContext('2d')?.drawImage(canvas, 0, 0);
  return copy;
}

/** Returns what stands before a black and before a white background, without either. */
export function cutOut(onBlack: HTMLCanvasElement, onWhite: HTMLCanvasElement): HTMLCanvasElement {
  const { width, height } = onBlack;
  const cut = blank(width, height);
  const context = cut.getContext('2d');
  const [black, white] = [onBlack, onWhite].map(
    (canvas) => canvas.getContext('2d')?.getImageData(0, 0, width, height).data,
  );
  if (!context || !black || !white) return onBlack;
  const picture = context.createImageData(width, height);
  // Where the background shows through, white is brighter than black by that part: at most by what tone mapping leaves of white.
  const brighter = (at: number) => [0, 1, 2].reduce((sum, part) => sum + white[at + part]! - black[at + part]!, 0);
  let most = LEAST_DIFFERENCE;
  for (let at = 0; at < black.length; at += 4) most = Math.max(most, brighter(at));
  for (let at = 0; at < black.length; at += 4) {
    const share = Math.max(0, Math.min(1, 1 - brighter(at) / most));
    for (let part = 0; part < 3; part++) picture.data[at + part] = share > 0 ? black[at + part]! / share : 0;
    picture.data[at + 3] = 255 * share;
  }
  context.putImageData(picture, 0, 0);
  return cut;
}

function blank(width: number, height: number): HTMLCanvasElement {
  return Object.assign(document.createElement('canvas'), { width, height });
}
