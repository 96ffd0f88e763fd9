// Rows and marks of the page that show something in the 3-D view.

function makeButton(cell, onClick) {
  const made = document.createElement('button');
  made.type = 'button';
  made.className = 'show';
  made.title = 'Show in the 3-D view';
  made.append(...cell.childNodes);
  made.addEventListener('click', () => onClick(made));
  cell.append(made);
}

/// Makes the first cell of each row of scans and registrations a button, and the pictures' marks
/// clickable. `show(kind, index, origin)` has kind 'scan' or 'registration'.
export function connectTables(show) {
  for (const kind of ['scan', 'registration']) {
    for (const row of document.querySelectorAll(`tr[data-${kind}]`)) {
      makeButton(row.cells[0], (origin) => show(kind, Number(row.dataset[kind]), origin));
    }
    for (const mark of document.querySelectorAll(`svg [data-${kind}]`)) {
      mark.style.cursor = 'pointer';
      mark.addEventListener('click', () => show(kind, Number(mark.dataset[kind]), null));
    }
  }
}
