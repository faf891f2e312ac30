// Lists what a page shows: its kind, words, element, contrast with what is behind it, whether it is large, and whether it cannot be used.
// Text: its color, with the opacity of all that it is in, on the colors of its ancestors. A sign, such as an icon: the better of its line
// and its filling. A control: the better of its edge and its filling, on what is around it.
() => {
    const paper = document.createElement('canvas').getContext('2d', { willReadFrequently: true }), known = new Map();
    const rgba = (css) => {
        if (!known.has(css)) {
            paper.clearRect(0, 0, 1, 1);
            paper.fillStyle = css;
            paper.fillRect(0, 0, 1, 1);
            const [r, g, b, a] = paper.getImageData(0, 0, 1, 1).data;
            known.set(css, [r, g, b, a / 255]);
        }
        return known.get(css);
    };
    const lineage = (e) => (e ? [...lineage(e.parentElement), e] : []);
    const faded = (e) => lineage(e).reduce((share, one) => share * getComputedStyle(one).opacity, 1);
    const on = (ground, css, share) => {
        const [r, g, b, a] = rgba(css);
        return [r, g, b].map((v, k) => v * a * share + ground[k] * (1 - a * share));
    };
    const ground = (e) => lineage(e).reduce((below, one) => on(below, getComputedStyle(one).backgroundColor, faded(one)), [255, 255, 255]);
    const luminance = (color) => {
        const [r, g, b] = color.map((v) => (v <= 0.04045 * 255 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const ratio = (a, b) => {
        const [less, more] = [luminance(a), luminance(b)].sort((x, y) => x - y);
        return (more + 0.05) / (less + 0.05);
    };
    const isSeen = (e) => {
        if (!e.checkVisibility({ opacityProperty: true, visibilityProperty: true }) || e.closest('[inert]')) return false;
        return [e, ...lineage(e).filter((one) => getComputedStyle(one).overflow !== 'visible')].every((one) => {
            const { width, height } = one.getBoundingClientRect();
            return width >= 2 && height >= 2;
        });
    };
    const edge = (style, below, share) => Math.max(1, ...['Top', 'Right', 'Bottom', 'Left']
        .filter((side) => parseFloat(style[`border${side}Width`]) > 0 && style[`border${side}Style`] !== 'none')
        .map((side) => ratio(on(below, style[`border${side}Color`], share), below)));
    const words = (e) => (e.ariaLabel || e.labels?.[0]?.textContent || e.innerText || e.value || '').trim();
    const found = [];
    const tell = (e, kind, contrast, large = false) => found.push([
        kind, words(e).replace(/\s+/g, ' ').slice(0, 60) || words(e.parentElement ?? e).slice(0, 60),
        `${e.tagName.toLowerCase()} ${(e.getAttribute('class') ?? '').replace(/\bm_\w+/g, '').trim()}`, contrast, large,
        !!e.closest(':disabled, [data-disabled=true], [aria-disabled=true]'),
    ]);
    for (const e of [...document.body.querySelectorAll('*')].filter(isSeen)) {
        const style = getComputedStyle(e), around = ground(e.parentElement), share = faded(e);
        const field = e.matches('input:not([type=checkbox], [type=hidden], [type=file]), textarea');
        const text = field ? e.value || e.placeholder : [...e.childNodes].filter((one) => one.nodeType === 3).map((one) => one.data).join('');
        if (text.trim() && !e.matches('script, style, noscript')) {
            const pixels = parseFloat(style.fontSize), below = ground(e);
            tell(e, text.trim() === '■' ? 'sign' : 'text', ratio(on(below, style.color, share), below), pixels >= 24 || (pixels >= 18.66 && style.fontWeight >= 700));
        }
        if (e.matches('svg')) {
            const box = e.parentElement.querySelector(':scope > input[type=checkbox]'), below = ground(box ?? e);
            const lines = [...e.querySelectorAll('path, circle, rect, line, polyline')].map((one) => getComputedStyle(one));
            const paints = lines.flatMap(({ stroke, fill }) => [stroke, fill]).filter((css) => css !== 'none' && rgba(css)[3]);
            tell(e, 'sign', Math.max(1, ...paints.map((css) => ratio(on(below, css, share), below))));
        }
        if (e.matches('[role=status] > span'))
            tell(e, 'sign', Math.max(edge(style, around, share), ratio(ground(e), around)));
        if (field || e.matches('[type=checkbox], .mantine-Slider-thumb, .mantine-Slider-bar'))
            tell(e, 'control', Math.max(edge(style, around, share), ratio(ground(e), around)));
        if (e.matches('.mantine-Slider-track')) {
            const track = getComputedStyle(e, '::before');
            tell(e, 'control', ratio(on(around, track.backgroundColor, share), around));
        }
        if (e.matches('button:not([role=tab]), a') && e.innerText.trim()) {  // one without an edge and a filling is known by its words
            const drawn = Math.max(edge(style, around, share), ratio(ground(e), around));
            if (drawn > 1.01) tell(e, 'control', drawn);
        }
        if (e.matches('[role=tab][aria-selected=true]')) {
            const under = style.boxShadow === 'none' ? 1 : ratio(on(around, style.boxShadow.match(/^[a-z-]+\([^)]*\)/)[0], share), around);
            tell(e, 'control', Math.max(under, edge(style, around, share)));
        }
    }
    return found;
}
