// SPDX-License-Identifier: GPL-2.0-or-later
// A heading that is pressed sorts its table by values, pressed again the other way round. Choices and words leave rows.
"use strict";
for (const box of document.querySelectorAll(".sortable")) {
    const table = box.querySelector("table"), body = table.tBodies[0], heads = [...table.tHead.rows[0].cells];
    const rows = [...body.rows];
    const key = (row, k) => {
        const cell = row.cells[k];
        return "v" in cell.dataset ? Number(cell.dataset.v) : cell.textContent;
    };
    const compare = (a, b) => {
        if (typeof a === "number" && typeof b === "number") return a - b;
        if (typeof a === typeof b) return a.localeCompare(b, "en", { numeric: true });
        return typeof a === "number" ? -1 : 1; // no number comes last
    };
    heads.forEach((head, k) => head.firstChild.addEventListener("click", () => {
        const up = head.getAttribute("aria-sort") !== "ascending";
        for (const other of heads) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
        rows.sort((a, b) => {
            const x = key(a, k), y = key(b, k);
            return typeof x === typeof y && !up ? compare(y, x) : compare(x, y);
        });
        body.append(...rows);
    }));
    const words = box.querySelector("input"), choices = [...box.querySelectorAll("select")], told = box.querySelector("output");
    const filter = () => {
        const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
        let left = 0;
        for (const row of rows) {
            const text = row.textContent.toLowerCase();
            row.hidden = !wanted.every((word) => text.includes(word)) ||
                choices.some((c) => c.value && row.cells[c.dataset.column].textContent !== c.value);
            left += !row.hidden;
        }
        told.textContent = `${left} of ${rows.length} rows`;
    };
    if (words) {
        words.addEventListener("input", filter);
        for (const choice of choices) choice.addEventListener("change", filter);
        filter();
    }
}
// On a phone the contents are closed.
if (matchMedia("(max-width: 60em)").matches) document.querySelector("nav details").open = false;
