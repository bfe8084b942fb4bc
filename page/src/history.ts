/** The last values of each feature, for the sparklines: one a tick. */

export const KEPT = 200;

export class FeatureHistory {
  private tick = -1;
  private columns: number[][] = [];

  record(tick: number, values: Float32Array): void {
    if (values.length !== this.columns.length || tick < this.tick) {
      this.columns = Array.from(values, () => []);
      this.tick = -1;
    }
    if (tick === this.tick) return;
    this.tick = tick;
    this.columns.forEach((column, index) => {
      column.push(values[index] ?? NaN);
      if (column.length > KEPT) column.shift();
    });
  }

  valuesOf(index: number): readonly number[] {
    return this.columns[index] ?? [];
  }

  clear(): void {
    this.columns = [];
    this.tick = -1;
  }
}
