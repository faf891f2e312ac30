"""Gives the controls of viser's page the names that screen readers need. Used by ``document``.

viser writes a label beside each field, but connects it to the first control only, or to none: sliders, their numbers, text
fields, and the second and third number of a vector have no name. A script in the page gives them one. Source: WCAG 2.2, criterion
4.1.2.
"""

SCRIPT = b"""<script>
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
