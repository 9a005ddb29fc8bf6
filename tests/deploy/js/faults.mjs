// What a check found wrong, all of it, and how it ends.
export class Faults {
  #all = [];
  add(text) {
    this.#all.push(text);
  }
  expect(holds, text) {
    if (!holds) this.add(text);
  }
  end(checked) {
    for (const text of this.#all) console.error(`FAULT: ${text}`);
    if (this.#all.length === 0) console.log(`${checked}: all as it should be`);
    process.exit(this.#all.length === 0 ? 0 : 1);
  }
}
