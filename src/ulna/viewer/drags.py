"""Ends a drag whose pointer was lost, by a script in the page. Used by the pages that ``viewer`` serves.

viser's handles end a drag only at ``pointerup``. The browser does not send it after ``pointercancel`` (a gesture, a lost pen),
and may not send it while another window is in front; then the handles would follow the pointer with no button pressed. A script
in the page sends the missing event. Source: W3C Pointer Events, section 4.1.3.
"""

SCRIPT = b"""<script>
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
