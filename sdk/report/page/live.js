// SPDX-License-Identifier: Apache-2.0
// A run that goes on: the page is rendered again with every event, and what has not changed in it stays.

const liveStates = {
  waits: ['low', 'no data yet'],
  'goes on': ['good', 'goes on'],
  over: ['low', 'over'],
  lost: ['bad', 'connection lost'],
};

const nameOf = (node) => (node.dataset && node.dataset.key) || node.id || node.nodeName;

/// Makes `old` what `fresh` is. Elements stay where they are alike, with what is opened, focused and selected in them.
function become(old, fresh) {
  if (old.nodeType !== Node.ELEMENT_NODE) {
    if (old.data !== fresh.data) old.data = fresh.data;
    return;
  }
  if (old.dataset.key) return;  // a drawing has its data already
  becomeAlike(old, fresh);
  const rest = [...old.childNodes];
  for (const child of [...fresh.childNodes]) {
    const i = rest.findIndex((node) => nameOf(node) === nameOf(child));
    if (i < 0) old.insertBefore(child, rest[0] || null);
    else {
      const [same] = rest.splice(i, 1);
      if (i > 0) old.insertBefore(same, rest[0]);
      become(same, child);
    }
  }
  for (const node of rest) node.remove();
}

function becomeAlike(old, fresh) {
  for (const { name, value } of fresh.attributes) if (name !== 'open' && old.getAttribute(name) !== value) old.setAttribute(name, value);
  for (const { name } of [...old.attributes]) if (name !== 'open' && !fresh.hasAttribute(name)) old.removeAttribute(name);
}

/// Renders the newest event, one at a time; not while something is dragged.
function follow() {
  let newest = null, isHeld = false;
  const source = new EventSource('events');
  const show = () => {
    if (newest === null || isHeld) return;
    setPayload(newest);
    newest = null;
    render();
    document.documentElement.dataset.live = payload.live;
  };
  source.addEventListener('message', ({ data }) => {
    if (newest === null) requestAnimationFrame(show);
    newest = data;
    if (data.startsWith('{"live":"over"')) source.close();
  });
  source.addEventListener('error', () => {
    if (payload.live === 'lost') return;
    payload.live = 'lost';
    render();
    document.documentElement.dataset.live = payload.live;
  });
  addEventListener('pointerdown', () => { isHeld = true; });
  for (const end of ['pointerup', 'pointercancel']) addEventListener(end, () => {
    isHeld = false;
    requestAnimationFrame(show);
  });
}
