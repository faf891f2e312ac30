"""Sends what is typed only when it is complete: at Enter, at Tab, or at a click elsewhere. Used by ``document``.

viser sends a field at every key: while 0.25 is typed, a dimension would be 0 for a moment, and a name that of another obstacle.
It also overwrites the field in which a person types when the value changes, as a joint's does while the arm moves. A script in
the page holds back what is typed until it is complete, and what the program writes until the field is left. Invalid numbers are
reset.
"""

SCRIPT = b"""<script>
(() => {
  const FIELD = 'input.mantine-NumberInput-input, input.mantine-TextInput-input';
  let held = null;  // the field that somebody types in; its text is not that of the program
  const hold = (field) => {
    const own = Object.getOwnPropertyDescriptor(field, 'value');  // React's, by which the program writes
    if (held || !own || !own.set) return;
    held = { field, own, before: field.value, after: null, typed: false };
    const set = (text) => { if (held) held.after = text; };
    Object.defineProperty(field, 'value', { configurable: true, get: () => own.get.call(field), set });
  };
  const release = () => {
    if (!held) return;
    const { field, own, before, after, typed } = held;
    held = null;
    Object.defineProperty(field, 'value', own);
    const text = field.value.trim();
    const wrong = field.matches('.mantine-NumberInput-input') && (text === '' || !Number.isFinite(Number(text)));
    if (typed && !wrong) field.dispatchEvent(new Event('input', { bubbles: true }));
    else if (typed || after !== null) own.set.call(field, after ?? before);
  };
  addEventListener('focusin', (e) => { if (e.target.matches?.(FIELD)) hold(e.target); }, true);
  addEventListener('beforeinput', (e) => { if (e.target.matches?.(FIELD)) hold(e.target); }, true);
  addEventListener('input', (e) => {
    if (held?.field !== e.target) return;
    held.typed = true;
    e.stopImmediatePropagation();
  }, true);
  addEventListener('keydown', (e) => { if (['Enter', 'Tab', 'ArrowUp', 'ArrowDown'].includes(e.key)) release(); }, true);
  addEventListener('pointerdown', (e) => { if (held && e.target !== held.field) release(); }, true);
  for (const left of ['change', 'focusout', 'pagehide']) addEventListener(left, release, true);
})();
</script>"""
