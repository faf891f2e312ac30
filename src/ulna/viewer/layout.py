"""Places the panel beside the scene on a wide page, and below it on a phone. Used by ``page``, ``document``.

On a wide page viser docks it. On a phone viser draws it over the lower part of the scene; a style sheet moves it below the scene.
"""

import viser

WIDTH_PX = 320  # of the docked panel: viser's "medium"
_PHONE = "div[style*='max-height: 60%'][style*='position: fixed']"  # viser's panel on a page of less than 36em
_FOLDED = "div[style*='width: 20em'] > div[style*='display: none']"

STYLE = f"""<style>
@media (max-width: 36em) {{
  div:has(> {_PHONE}) {{ flex-direction: column; }}
  {_PHONE} {{ position: relative !important; width: 100% !important; flex-shrink: 0; }}
  {_PHONE} {{ max-height: 45% !important; min-height: 45% !important; }}
  {_PHONE}:has({_FOLDED}) {{ min-height: 0 !important; }}
  {_PHONE} div[style*='width: 20em'] {{ width: 100% !important; }}
}}
</style>""".encode()


def dock(server: viser.ViserServer) -> None:
    """Dock the panel beside the scene; people can still move or fold it."""
    server.gui.configure_theme(control_width="medium", show_logo=False, show_share_button=False)
    server.gui.main_panel.dock_right()
