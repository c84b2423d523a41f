// What the pages do beside showing: load the plots, edit cuts.
"use strict";

// Words: the page has them in its language, with {names} to be filled in.
const words = JSON.parse(document.querySelector("#words").textContent);
const say = (key, values = {}) =>
  words[key].replace(/\{(\w+)\}/g, (_, name) => values[name]);
const language = document.documentElement.lang;
const point = new Intl.NumberFormat(language).format(0.5)[1];
// What was said in another language than the page's says so to who reads aloud.
const put = (place, text, lang) => {
  place.textContent = text;
  if (lang && lang !== language) place.lang = lang;
  else place.removeAttribute("lang");
};
const refusal = (text, lang) => Object.assign(new Error(text), { lang });

// Plots: the library is large and is loaded only where there are some.
const drawPlots = (() => {
  const load = (address) => new Promise((done) => {
    const script = document.createElement("script");
    script.src = address;
    script.addEventListener("load", done);
    document.head.append(script);
  });
  const { plotly, plots } = document.body.dataset;
  let library;
  return async () => {
    if (!document.querySelector(".plotly-graph-div > script")) return;
    library ??= load(plotly);
    await library;
    await load(plots);
    document.body.classList.add("drawn");
  };
})();
drawPlots();

// Tables: sorted by a column's title, downloaded as CSV, and on a narrow screen a card a row.
const beginTables = (() => {
  const read = (cell) => (cell.dataset.value ?? cell.textContent.trim().replace(/\s+/g, " "));
  const size = (text) =>
    parseFloat(text.replace("−", "-").replaceAll("\u202f", "").replace(point, "."));
  const before = (a, b) => {
    const [x, y] = [size(a), size(b)];
    if (!Number.isNaN(x) && !Number.isNaN(y) && !/^\d{4}-\d/.test(a)) return x - y;
    return a.localeCompare(b, undefined, { numeric: true });
  };
  const sort = (table, title, column) => {
    const up = title.getAttribute("aria-sort") !== "ascending";
    table.querySelectorAll("th[aria-sort]").forEach((one) => one.removeAttribute("aria-sort"));
    title.setAttribute("aria-sort", up ? "ascending" : "descending");
    const body = table.tBodies[0];
    const rows = [...body.rows].map((row) => [read(row.cells[column]), row]);
    rows.sort(([a], [b]) => (!a - !b) || (up ? before(a, b) : before(b, a)));
    body.append(...rows.map(([, row]) => row));
  };
  const csv = (table) => [...table.rows].map((row) => [...row.cells].map((cell) => {
    const text = cell.innerText.trim().replace(/\s+/g, " ");
    return /[",;]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  }).join(point === "," ? ";" : ",")).join("\r\n");  // as tables of the language are read
  const save = (table, name) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob(["\ufeff", csv(table)], { type: "text/csv" }));
    link.download = `${name}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  };
  const begin = (table) => {
    const titles = [...table.tHead.rows[0].cells];
    [...table.tBodies[0].rows].forEach((row) => [...row.cells].forEach((cell, k) => {
      cell.dataset.label = titles[k].textContent;
    }));
    titles.forEach((title, k) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      button.append(...title.childNodes);
      button.addEventListener("click", () => sort(table, title, k));
      title.append(button);
    });
    const button = document.createElement("button");
    button.type = "button";
    button.className = "plain";
    button.textContent = say("csv");
    button.addEventListener("click", () => save(table, table.dataset.table));
    const below = document.createElement("p");
    below.className = "below";
    below.append(button);
    table.parentElement.after(below);
  };
  return (part) => part.querySelectorAll("table[data-table]").forEach(begin);
})();
beginTables(document);

// Pieces of a page that take a while to make: asked for, and put in when they are there.
const askPiece = async (address, options, { status, into, button }) => {
  const begun = Date.now();
  const tell = () => put(status, say("working", { seconds: Math.round((Date.now() - begun) / 1000) }));
  const ticking = setInterval(tell, 1000);
  tell();
  button.disabled = true;
  status.className = "";
  try {
    const got = await fetch(address, options);
    const text = await got.text();
    clearInterval(ticking);
    if (!got.ok) {
      const said = new DOMParser().parseFromString(text, "text/html").querySelector(".said");
      const lang = said?.querySelector("[lang]")?.lang;
      throw refusal(said ? said.textContent : say("status", { status: got.status }), lang);
    }
    into.innerHTML = text;
    into.hidden = false;
    beginTables(into);
    status.textContent = "";
    await drawPlots();
  } catch (error) {
    put(status, error.message, error.lang);
    status.className = "said";
  } finally {
    clearInterval(ticking);
    button.disabled = false;
  }
};

document.querySelectorAll("[data-piece]").forEach((section) => {
  const [button, status, into] = ["button", "[role=status]", "[aria-live]"].map((one) =>
    section.querySelector(one));
  const ask = () => askPiece(section.dataset.piece, {}, { status, into, button });
  button.addEventListener("click", ask);
  if ("now" in section.dataset) {
    button.hidden = true;
    ask().then(() => { button.hidden = !into.hidden && into.childElementCount > 0; });
  }
});

// A machine that learns: how far it is, until it is done. A service that is silent is asked again.
document.querySelectorAll("[data-learning]").forEach((section) => {
  let last = "";
  const ask = async () => {
    try {
      const got = await fetch(section.dataset.learning);
      const text = await got.text();
      if (got.ok && text !== last) {
        last = text;
        section.innerHTML = text;
        beginTables(section);
      }
    } catch {
      // it may be back when it is asked next
    }
    next();
  };
  const next = () => {
    if (section.querySelector("[data-running]")) setTimeout(ask, 700);
  };
  next();
});

// A file that is dropped on a form: sent with the question, answered by a piece of the page.
const onDrop = (form, place, asked) => {
  const cuts = document.querySelector("form [name=material]").form;
  const file = form.querySelector("[type=file]");
  const into = document.querySelector(place);
  const ask = () => {
    const status = form.querySelector("[role=status]");
    const sent = new FormData();
    let address, parts;
    try {
      ({ address, parts } = asked(cuts, [...file.files]));
    } catch (error) {
      put(status, error.message);
      status.className = "said";
      return;
    }
    Object.entries(parts).forEach(([key, part]) => sent.append(key, part));
    const headers = { "X-CSRF-Token": document.body.dataset.csrf };
    askPiece(address, { method: "POST", body: sent, headers }, { status, into, button: form.querySelector("button:not([type])") });
  };
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    ask();
  });
  form.addEventListener("dragover", (event) => event.preventDefault());
  form.addEventListener("drop", (event) => {
    event.preventDefault();
    file.files = event.dataTransfer.files;
    file.dispatchEvent(new Event("change"));
    if (form.reportValidity()) ask();
  });
};

// A tool point: with the cuts, as they stand in their form.
(() => {
  const form = document.querySelector("[data-dynamics]");
  if (!form) return;
  onDrop(form, "#of-file", (cuts, [dynamics]) => {
    document.querySelector("#answer")?.remove();  // it was of the modes
    const query = new URLSearchParams(new FormData(cuts));
    return { address: `${form.dataset.dynamics}?${query}`, parts: { dynamics } };
  });
})();

// Groups of fields that are numbered, added and taken out, one at least.
const beginGroups = (place, title, add, begin = () => {}) => {
  const all = () => [...place.querySelectorAll("fieldset")];
  const number = () => all().forEach((group, k) => {
    group.querySelector("legend").textContent = say(title, { number: k + 1 });
    group.querySelector("[data-remove]").hidden = all().length === 1;
  });
  const start = (group) => {
    group.querySelector("[data-remove]").addEventListener("click", () => {
      group.remove();
      number();
    });
    begin(group);
  };
  all().forEach(start);
  number();
  if (!add) return;
  add.hidden = false;
  add.addEventListener("click", () => {
    const last = all().at(-1);
    const made = last.cloneNode(true);
    made.querySelectorAll("input, select").forEach((field, k) => {
      field.value = last.querySelectorAll("input, select")[k].value;
    });
    last.after(made);
    start(made);
    number();
    made.querySelector("input, select").focus();
  });
};

// Cuts of a job: each operation shows the fields that it has.
(() => {
  const cuts = document.querySelector("[data-cuts]");
  if (!cuts) return;
  const keys = JSON.parse(cuts.dataset.cuts);
  const show = (cut) => {
    const shown = keys[cut.querySelector("[name=operation]").value];
    cut.querySelectorAll("[data-key]").forEach((field) => {
      const has = shown.includes(field.dataset.key);
      field.hidden = !has;
      if (!has) field.querySelector("input").value = "";
    });
  };
  beginGroups(cuts, "cut", document.querySelector("[data-add]"), (cut) => {
    cut.querySelector("[name=operation]").addEventListener("change", () => show(cut));
    show(cut);
  });
})();

// A program: with the pair, the stock, its tools, and how it is read where it does not say it.
(() => {
  const form = document.querySelector("[data-program]");
  if (!form) return;
  const stated = form.querySelector("[data-stated]");
  const { program: file, stock } = form.elements;
  const tools = stated.querySelector("[data-tools]");
  const keys = JSON.parse(tools.dataset.tools);
  const groups = () => [...tools.querySelectorAll("fieldset")];
  const allow = (label, has) => {
    label.hidden = !has;
    label.querySelector("input, select").disabled = !has;
  };
  const showTool = (group) => {
    const kind = group.querySelector("[name=kind]");
    [...kind.options].forEach((one) => {
      one.hidden = one.disabled = !one.dataset.of.split(" ").includes(stock.value);
    });
    if (kind.selectedOptions[0].disabled) kind.value = [...kind.options].find((one) => !one.disabled).value;
    group.querySelectorAll("[data-key]").forEach((label) =>
      allow(label, (keys[kind.value] ?? []).includes(label.dataset.key)));
  };
  const show = () => {
    stated.querySelectorAll("label[data-of]").forEach((label) => allow(label, label.dataset.of === stock.value));
    groups().forEach(showTool);
  };
  const add = form.querySelector("[data-add-tool]");
  beginGroups(tools, "tool", add, (group) => {
    group.querySelector("[name=kind]").addEventListener("change", () => showTool(group));
    showTool(group);
  });
  add.addEventListener("click", () => { groups().at(-1).querySelector("[name=called]").value = ""; });
  stock.addEventListener("change", show);
  show();

  const isJob = (one) => one.name.toLowerCase().endsWith(".toml");
  // The tools that a program calls, as long as nobody has stated one. A lathe's last two digits are an offset.
  const callsOf = (text) => {
    const words = text.replace(/\([^)]*\)|;.*/g, "").matchAll(/(?<![A-Z])T\s*(?:=\s*"([^"]+)"|=?\s*(\d+))/gi);
    const called = [...words].map(([, name, digits]) =>
      name ?? (stock.value === "bar" && digits.length > 2 ? digits.slice(0, -2) : digits).replace(/^0+/, ""));
    return [...new Set(called)].filter(Boolean).slice(0, 30);
  };
  const nameTools = (calls) => {
    const [first] = groups();
    if (groups().length > 1 || first.querySelector("[name=called]").value) return;
    calls.forEach((_, k) => { if (k) add.click(); });
    groups().forEach((group, k) => { group.querySelector("[name=called]").value = calls[k] ?? ""; });
  };
  file.addEventListener("change", async () => {
    const sent = [...file.files];
    stated.disabled = sent.some(isJob);
    const program = sent.find((one) => !isJob(one));
    if (program && !stated.disabled) nameTools(callsOf(await program.text()));
  });

  const typed = (fields) => Object.fromEntries(fields
    .filter((field) => !field.disabled && field.value.trim()).map((field) => [field.name, field.value.trim()]));
  const fieldsOf = (part) => [...part.querySelectorAll("[name]")];
  const said = () => {
    const alone = fieldsOf(stated).filter((field) => field !== stock && !tools.contains(field));
    const { block_mm: block, diameter, ...program } = typed(alone);
    if (block) program.block_mm = alone.filter(({ name }) => name === "block_mm").map(({ value }) => value);
    if (diameter) program.diameter = diameter === "true";
    program.tools = {};
    groups().map((group) => typed(fieldsOf(group))).forEach(({ called = "other", ...tool }) => {
      if (!tool.kind) return;
      if (called in program.tools) throw refusal(say("twice", { name: called }));
      program.tools[called] = tool;
    });
    return program;
  };
  onDrop(form, "#of-program", (cuts, sent) => {
    const [program, ...others] = sent.filter((one) => !isJob(one));
    if (!program || others.length) throw refusal(say("program"));
    const { material, tool } = cuts.elements;
    if (!sent.some(isJob) && ![material, tool].every((field) => field.reportValidity())) throw refusal("");
    const job = sent.find(isJob) ?? JSON.stringify(
      { name: program.name, material: material.value, tool: tool.value, program: said() });
    return { address: form.dataset.program, parts: { job, program } };
  });
})();

// Modes of a tool point.
(() => {
  const modes = document.querySelector("[data-modes]");
  if (modes) beginGroups(modes, "mode", document.querySelector("[data-add-mode]"));
})();

// Files that are dropped: one with a side file is imported; of another it is shown first what its
// columns may be, and a person chooses. Nothing is kept before it is imported.
(() => {
  const drop = document.querySelector("[data-import]");
  if (!drop) return;
  const list = document.querySelector("[data-imports]");
  const csrf = document.body.dataset.csrf;
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const make = (tag, text = "", kind = "") =>
    Object.assign(document.createElement(tag), { textContent: text, className: kind });

  const line = (name) => {
    const shown = { name, said: make("p"), bar: make("progress"), piece: make("div") };
    const item = make("li", "", "card");
    shown.said.setAttribute("role", "status");
    shown.bar.setAttribute("aria-label", name);
    item.append(make("h2", name), shown.said, shown.bar, shown.piece);
    list.prepend(item);
    return shown;
  };
  const tell = ({ said, bar }, text, state, lang) => {
    put(said, text, lang);
    said.className = state ? `said ${state}` : "";
    bar.hidden = Boolean(state);
  };
  const ask = (shown, text) => {
    tell(shown, text);
    shown.bar.hidden = true;
  };
  const refused = (request) => {
    const kind = request.getResponseHeader("Content-Type") ?? "";
    if (kind.includes("json")) {
      const lang = request.getResponseHeader("Content-Language");
      return refusal(JSON.parse(request.responseText).detail, lang);
    }
    const page = new DOMParser().parseFromString(request.responseText, "text/html");
    const said = page.querySelector(".said");
    const text = said ? said.textContent : say("status", { status: request.status });
    return refusal(text, said?.querySelector("[lang]")?.lang);
  };
  const send = (address, parts, shown) => new Promise((done, failed) => {
    const request = new XMLHttpRequest();
    request.open("POST", address);
    request.setRequestHeader("X-CSRF-Token", csrf);
    request.setRequestHeader("X-Shown-In", language);
    request.upload.addEventListener("progress", (sent) => {
      if (!sent.lengthComputable) return;
      shown.bar.max = sent.total;
      shown.bar.value = sent.loaded;
      tell(shown, say("sending", { percent: Math.round((100 * sent.loaded) / sent.total) }));
    });
    request.upload.addEventListener("load", () => {
      shown.bar.removeAttribute("value");
      tell(shown, say("reading"));
    });
    request.addEventListener("load", () =>
      (request.status < 300 ? done(request.responseText) : failed(refused(request))));
    request.addEventListener("error", () => failed(refusal(say("silent"))));
    const form = new FormData();
    Object.entries(parts).forEach(([key, part]) => {
      if (part) form.append(key, part, part.name ?? key);
    });
    shown.bar.hidden = false;
    request.send(form);
  });
  // What the database keeps of a file is in English: then so is the whole line.
  const came = ({ recording_id: number, cuts, already_there: there, timing, notes }) => {
    const first = there ? say("there", { number }) : say("new", { number, cuts });
    const also = [...timing.map((sentence) => say("time", { sentence })), ...notes];
    return [[first, ...also].join("; "), also.length ? "en" : language];
  };
  const follow = async (number, shown) => {
    for (;;) {
      const got = await fetch(`/api/v1/imports/${number}`, { headers: { "X-Shown-In": language } });
      const now = await got.json();
      if (!got.ok) throw refusal(now.detail, got.headers.get("Content-Language"));
      if (now.state === "refused") throw refusal(now.refused, got.headers.get("Content-Language"));
      if (now.state === "done") return came(now.came_in);
      if (now.progress) tell(shown, `${now.state}: ${now.progress}`, "", "en");
      else tell(shown, say(now.state));
      await wait(400);
    }
  };
  const take = async (file, side, shown) => {
    shown.piece.hidden = true;
    try {
      const begun = await send(drop.dataset.import, { recording: file, side }, shown);
      const [text, lang] = await follow(JSON.parse(begun).number, shown);
      tell(shown, text, "good", lang);
      shown.piece.replaceChildren();
    } catch (error) {
      tell(shown, error.message, "bad", error.lang);
      shown.piece.hidden = false;
      if (!shown.piece.childElementCount) offer(file, side, shown);
    }
  };
  const offer = (file, side, shown) => {
    const button = make("button", say("look"), "plain");
    button.type = "button";
    button.addEventListener("click", () => look(file, { side }, shown));
    shown.piece.replaceChildren(button);
  };
  const toml = (text) => new File([text], "side.toml", { type: "application/toml" });

  // What was chosen: the text of the side file once it was changed, else each row of the tables.
  const chosen = (form) => {
    const text = form.elements.side;
    if (text.value !== text.defaultValue) return { side: toml(text.value) };
    const columns = new Map();
    form.querySelectorAll("[data-column]").forEach((row) => {  // time may stand in several tables
      const of = (name) => row.querySelector(`[name=${name}]`);
      const [channel, unit, turned] = ["channel", "unit", "turned"].map(of);
      const changed = [channel, unit].some((one) => one.value !== one.defaultValue);
      const { column } = row.dataset;
      if (columns.has(column) && !changed) return;
      const one = { column, channel: channel.value.trim(), unit: unit.value.trim() };
      columns.set(column, { ...one, turned: turned?.checked ?? false });
    });
    const values = (fields, key) =>
      Object.fromEntries([...fields].map((one) => [key(one), one.value.trim()]));
    const choices = {
      columns: [...columns.values()],
      text: values(form.querySelectorAll("[data-text] :is(input, select)"), (one) => one.name),
      operations: values(form.querySelectorAll("[data-word]"), (one) => one.dataset.word),
    };
    return { side: toml(text.value), choices: new Blob([JSON.stringify(choices)]) };
  };
  const begin = (form, file, shown) => {
    const importing = form.querySelector("[data-take]");
    const hint = form.querySelector("[role=status]");
    form.addEventListener("input", () => {
      importing.disabled = true;
      form.querySelector(".good")?.remove();  // it was said of other choices
      put(hint, say("check"));
    });
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      look(file, chosen(form), shown);
    });
    importing.addEventListener("click", () => take(file, toml(form.elements.side.value), shown));
    form.querySelector("[data-leave]").addEventListener("click", () => {
      shown.piece.replaceChildren();
      tell(shown, say("left"), "bad");
    });
    form.querySelector("[data-save]").addEventListener("click", () => {
      const link = make("a");
      link.href = URL.createObjectURL(toml(form.elements.side.value));
      link.download = `${stem(file)}.toml`;
      link.click();
      URL.revokeObjectURL(link.href);
    });
  };
  const look = async (file, { side, choices }, shown) => {
    const again = shown.piece.childElementCount > 0;
    const buttons = [...shown.piece.querySelectorAll("button")];
    const were = buttons.map((button) => button.disabled);
    buttons.forEach((button) => { button.disabled = true; });
    try {
      const text = await send(drop.dataset.look, { recording: file, side, choices }, shown);
      shown.piece.innerHTML = text;
      const form = shown.piece.querySelector("form");
      if (!again && "plain" in form.dataset) {
        shown.piece.replaceChildren();
        await take(file, null, shown);
        return;
      }
      ask(shown, say("choose"));
      begin(form, file, shown);
      if (again) form.querySelector("[tabindex]").focus();
    } catch (error) {
      tell(shown, error.message, "bad", error.lang);
      buttons.forEach((button, k) => { button.disabled = were[k]; });
    }
  };
  const stem = (file) => file.name.replace(/\.[^.]+$/, "");
  const takeAll = async (files) => {
    const sides = files.filter((file) => file.name.toLowerCase().endsWith(".toml"));
    const recordings = files.filter((file) => !sides.includes(file));
    sides.filter((side) => !recordings.some((file) => stem(file) === stem(side))).forEach((side) =>
      tell(line(side.name), say("alone"), "bad"));
    for (const file of recordings) {
      const side = sides.find((one) => stem(one) === stem(file));
      const shown = line(file.name);
      await (side ? take(file, side, shown) : look(file, {}, shown));
    }
  };
  const input = drop.querySelector("input");
  input.addEventListener("change", () => takeAll([...input.files]).then(() => { input.value = ""; }));
  ["dragover", "dragleave", "drop"].forEach((what) => drop.addEventListener(what, (event) => {
    event.preventDefault();
    drop.classList.toggle("over", what === "dragover");
    if (what === "drop") takeAll([...event.dataTransfer.files]);
  }));
})();
