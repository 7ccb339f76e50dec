// The chooser of load steps: a slider, a button to either side, and play.

const PLAY_MS = 6000;
const SHORTEST_MS = 100;
// below the delay of announced values, so that only the last step's are
const LONGEST_MS = 0.9 * REST_MS;

class Steps {
  // `changed` is called with the words for screen readers, empty where the slider says them or steps follow each other.
  constructor(root, names, changed) {
    this.names = names;
    this.changed = changed;
    this.last = Math.max(0, names.length - 1);
    this.at = this.last;
    [this.slider, this.output, this.play] = ["#viewer-step", "#viewer-step-name", "#viewer-play"].map((selector) =>
      root.querySelector(selector)
    );
    this.buttons = new Map([[-1, root.querySelector("#viewer-previous")], [1, root.querySelector("#viewer-next")]]);
    const several = names.length > 1;
    for (const selector of [".viewer-steps", ".viewer-step-keys"]) root.querySelector(selector).hidden = !several;
    root.querySelector("#viewer-common").parentElement.hidden = !several;
    const note = root.querySelector(".viewer-steps-note");
    note.hidden = !note.textContent;
    if (!several) return;
    this.slider.max = String(this.last);
    this.slider.addEventListener("input", () => {
      this.pause();
      this.go(this.slider.valueAsNumber, "");
    });
    for (const [way, button] of this.buttons) button.addEventListener("click", () => this.next(way));
    this.play.addEventListener("click", () => (this.timer ? this.pause(this.words()) : this.start()));
    this.show();
  }

  words() {
    return `Load step ${this.names[this.at]}`;
  }

  // The step after this one or before it; at the ends it stays.
  next(way) {
    if (!this.last) return;
    this.pause();
    this.go(Math.min(Math.max(this.at + way, 0), this.last));
  }

  go(step, words = undefined) {
    this.at = step;
    this.show();
    this.changed(words ?? this.words());
  }

  show() {
    this.slider.value = String(this.at);
    this.slider.setAttribute("aria-valuetext", this.names[this.at]);
    this.output.textContent = this.words();
    for (const [way, button] of this.buttons) {
      button.setAttribute("aria-disabled", String(this.at === (way < 0 ? 0 : this.last)));
    }
  }

  // From the first step if the last one is shown.
  start() {
    this.play.textContent = "pause";
    const pace = Math.min(Math.max(PLAY_MS / this.names.length, SHORTEST_MS), LONGEST_MS);
    const onward = () => {
      this.go(this.at + 1, "");
      if (this.at === this.last) this.pause(this.words());
    };
    this.timer = setInterval(onward, pace);
    if (this.at === this.last) this.go(0, "");
  }

  pause(words = "") {
    if (!this.timer) return;
    clearInterval(this.timer);
    this.timer = undefined;
    this.play.textContent = "play";
    if (words) this.changed(words);
  }

  // Paper has the last step; the one before is shown again afterwards.
  print() {
    this.pause();
    this.before = this.at;
    if (this.at !== this.last) this.go(this.last, "");
  }

  printed() {
    if (this.before !== undefined && this.before !== this.at) this.go(this.before, "");
    this.before = undefined;
  }
}
