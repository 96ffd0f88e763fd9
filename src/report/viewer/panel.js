// The controls around the picture, made of plain form elements.
import {MODES} from './colours.js';

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function button(text, onClick) {
  const made = element('button', {type: 'button'}, text);
  made.addEventListener('click', onClick);
  return made;
}

function toggle(text, onChange) {
  const box = element('input', {type: 'checkbox'});
  box.checked = true;
  box.addEventListener('change', () => onChange(box.checked));
  return {label: element('label', {}, box, ' ' + text), box};
}

function range(text, low, high, step, value, onInput) {
  const input = element('input', {type: 'range', min: low, max: high, step});
  input.value = value;
  input.addEventListener('input', () => onInput(Number(input.value)));
  return element('label', {}, text + ' ', input);
}

/// The picture with its controls. `actions` are what they do.
export class Panel {
  constructor(box, actions) {
    this.box = box;
    this.canvas = element('canvas', {
      tabindex: '0', role: 'application',
      'aria-label': '3-D view of the map. Arrow keys turn it, with shift they move it, ' +
        'plus and minus zoom.',
    });
    this.picture = element('div', {class: 'picture'}, this.canvas);
    this.info = element('p', {class: 'info', 'aria-live': 'polite'});
    this.legend = element('ul', {class: 'legend'});
    this.controls = element('div', {class: 'controls', role: 'group', 'aria-label': '3-D view'});
    this.layers = element('div', {class: 'controls', role: 'group', 'aria-label': 'What is shown'});
    this.hint = element('p', {class: 'note'},
      'Drag to turn, right button or two fingers to move; click a point to see what it is. ' +
      'After a click or a tap the wheel and single fingers belong to the view.');
    box.replaceChildren(
      this.controls, this.picture, this.info, this.legend, this.layers, this.hint);
    this.addColours(actions);
    this.controls.append(
      button('Whole site', actions.showAll), button('From above', actions.fromAbove));
    if (document.fullscreenEnabled) {
      this.controls.append(button('Full screen', () => this.picture.requestFullscreen()));
    }
  }

  addColours(actions) {
    this.select = element('select', {});
    for (const [value, text] of MODES) this.select.append(element('option', {value}, text));
    this.select.addEventListener('change', () => actions.setMode(this.select.value));
    this.controls.append(element('label', {}, 'Colour by ', this.select));
  }

  addLayer(text, shown, onChange) {
    const {label, box} = toggle(text, onChange);
    box.checked = shown;
    this.layers.append(label);
  }

  addRange(...options) {
    this.layers.append(range(...options));
  }

  showLegend(entries) {
    this.legend.replaceChildren(...entries.map(({text, background, wide}) => {
      const swatch = element('span', {class: wide ? 'swatch wide' : 'swatch'});
      if (background) swatch.style.background = background;
      return element('li', {}, ...(background ? [swatch] : []), text);
    }));
  }

  /// Text about what is chosen; `buttons` are pairs of text and action.
  say(text, buttons = []) {
    this.info.replaceChildren(text, ...buttons.flatMap(([label, act]) => [' ', button(label, act)]));
  }
}
