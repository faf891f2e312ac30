"""Adds to viser's page: a title, names for screen readers, scripts, a style; docks its panel."""

import html
import http
from typing import Any

import viser

from ulna.viewer.configuration import COPY_SCRIPT

_TITLE = b"<title>Viser</title>"

# Gives the controls of viser's page the names that screen readers need. viser writes a label beside each field, but connects it
# to the first control only, or to none: sliders, their numbers, text fields, and the second and third number of a vector have no
# name. A script in the page gives them one. Source: WCAG 2.2, criterion 4.1.2.
_NAMES = b"""<script>
(() => {
  const FIELDS = 'input:not([type=hidden]):not([type=file]), textarea, [role=slider]';
  const named = (e) => e.ariaLabel || (e.labels && e.labels.length) || e.getAttribute('aria-labelledby');
  const name = (e, words) => { if (!named(e)) e.setAttribute('aria-label', words); };
  const rowOf = (label) => {
    let row = label;
    while (row.parentElement && row.parentElement.querySelectorAll('label[for]').length === 1) row = row.parentElement;
    return row;
  };
  const axes = ['x', 'y', 'z'];
  const nameAll = () => {
    for (const label of document.querySelectorAll('label[for]')) {
      const fields = [...rowOf(label).querySelectorAll(FIELDS)];
      const words = label.textContent.trim();
      fields.forEach((e, k) => name(e, fields.length === 3 ? `${words}, ${axes[k]}` : words));
    }
    for (const e of document.querySelectorAll('input:not([type=hidden]):not([type=file])'))
      name(e, e.closest('div[class*=InputWrapper]')?.textContent.trim() || 'Server');
    for (const e of document.querySelectorAll('input[type=file]')) name(e, e.parentElement.textContent.trim() || 'File');
    for (const e of document.querySelectorAll('button'))
      if (!e.textContent.trim()) name(e, e.matches('[class*=CloseButton]') ? 'Close' : 'Settings');
  };
  let waiting = false;
  new MutationObserver(() => {
    if (waiting) return;
    waiting = true;
    setTimeout(() => { waiting = false; nameAll(); }, 100);
  }).observe(document, { childList: true, subtree: true });
})();
</script>"""

# Ends a drag whose pointer was lost, by a script in the page. viser's handles end a drag only at pointerup. The browser does not
# send it after pointercancel (a gesture, a lost pen), and may not send it while another window is in front; then the handles
# would follow the pointer with no button pressed. A script in the page sends the missing event. Source: W3C Pointer Events,
# section 4.1.3.
_DRAGS = b"""<script>
(() => {
  const pressed = new Map();  // the last event of each pointer that was pressed on the scene
  const end = (id) => {
    const last = pressed.get(id);
    if (!pressed.delete(id)) return;
    const { pointerType, isPrimary, clientX, clientY } = last;
    const about = { pointerId: id, pointerType, isPrimary, clientX, clientY, bubbles: true, cancelable: true };
    last.target.dispatchEvent(new PointerEvent('pointerup', about));
  };
  const endAll = () => [...pressed.keys()].forEach(end);
  addEventListener('pointerdown', (e) => { if (e.target instanceof HTMLCanvasElement) pressed.set(e.pointerId, e); }, true);
  addEventListener('pointerup', (e) => pressed.delete(e.pointerId), true);
  addEventListener('pointercancel', (e) => end(e.pointerId), true);
  addEventListener('pointermove', (e) => { if (e.buttons === 0) end(e.pointerId); }, true);
  addEventListener('blur', endAll);
  document.addEventListener('visibilitychange', () => { if (document.hidden) endAll(); });
})();
</script>"""

# Sends what is typed only when it is complete: at Enter, at Tab, or at a click elsewhere. viser sends a field at every key: while
# 0.25 is typed, a dimension would be 0 for a moment, and a name that of another obstacle. It also overwrites the field in which a
# person types when the value changes, as a joint's does while the arm moves. A script in the page holds back what is typed until
# it is complete, and what the program writes until the field is left. Invalid numbers are reset.
_TYPED = b"""<script>
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

# Places the panel beside the scene on a wide page, and below it on a phone. On a wide page viser docks it. On a phone viser draws
# it over the lower part of the scene; a style sheet moves it below the scene.
WIDTH_PX = 320  # of the docked panel: viser's "medium"
_PHONE = "div[style*='max-height: 60%'][style*='position: fixed']"  # viser's panel on a page of less than 36em
_FOLDED = "div[style*='width: 20em'] > div[style*='display: none']"

_STYLE = f"""<style>
@media (max-width: 36em) {{
  div:has(> {_PHONE}) {{ flex-direction: column; }}
  {_PHONE} {{ position: relative !important; width: 100% !important; flex-shrink: 0; }}
  {_PHONE} {{ max-height: 45% !important; min-height: 45% !important; }}
  {_PHONE}:has({_FOLDED}) {{ min-height: 0 !important; }}
  {_PHONE} div[style*='width: 20em'] {{ width: 100% !important; }}
}}
</style>""".encode()


def completed(response: Any, title: str) -> Any:
    """A successful response with the title, the scripts and the style inserted; any other response unchanged."""
    if response is None or response.status_code != http.HTTPStatus.OK:
        return response
    head, found, rest = response.body.partition(b"</head>")
    head = head.replace(_TITLE, f"<title>{html.escape(title)}</title>".encode())
    response.body = head + _NAMES + _DRAGS + _TYPED + COPY_SCRIPT + _STYLE + found + rest
    del response.headers["Content-Length"]
    response.headers["Content-Length"] = str(len(response.body))
    return response


def asks_for_page(request: Any) -> bool:
    """Whether a request is for the page itself. If so, its Accept-Encoding is removed, so that the text is not compressed."""
    if request.path.partition("?")[0] not in ("/", "/index.html"):
        return False
    while "Accept-Encoding" in request.headers:
        del request.headers["Accept-Encoding"]
    return True


def dock(server: viser.ViserServer) -> None:
    """Dock the panel beside the scene; people can still move or fold it."""
    set_theme(server, dark=False)
    server.gui.main_panel.dock_right()


def set_theme(server: viser.ViserServer, *, dark: bool) -> None:
    """Show the page in light or dark colours."""
    server.gui.configure_theme(control_width="medium", show_logo=False, show_share_button=False, dark_mode=dark)
