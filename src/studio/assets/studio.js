"use strict";
// The studio: the text goes to the server, and what it answers is shown. Data never becomes markup.
(() => {
  const token = new URLSearchParams(location.search).get("token") || "";
  const by = (id) => document.getElementById(id);
  const text = by("text");
  let name = "mirror";
  let frame = null;
  let form = null;
  // Number of the last change; answers to older ones are not shown.
  let change = 0;
  // Milliseconds of quiet after which the full picture is asked for.
  const QUIET_MS = 400;
  // Milliseconds in which a picture follows a slider; where the last took longer, a sketch of the mirror follows it.
  const FOLLOW_MS = 110;
  let tookMs = 0;

  async function ask(method, path, body) {
    const headers = { "X-Morion-Token": token };
    if (body) headers["Content-Type"] = "application/json";
    const response = await fetch(path, { method, headers, body: body && JSON.stringify(body), cache: "no-store" });
    const isJson = (response.headers.get("Content-Type") || "").startsWith("application/json");
    if (!isJson) {
      if (!response.ok) throw { message: "the server answers " + response.status, status: response.status };
      return response.blob();
    }
    const answer = await response.json();
    if (!response.ok) throw { ...answer.error, status: response.status };
    return answer;
  }
  const post = (path, body = {}) => ask("POST", path, body);
  const source = () => ({ name, text: text.value });
  const message = (error) => {
    const said = error && error.message ? error.message : String(error);
    return said === "Failed to fetch" ? "morion studio has ended; start it again" : said + (error.hint ? " (" + error.hint + ")" : "");
  };
  const isOld = (error) => error && error.status === 409;

  function element(kind, content, className) {
    const made = document.createElement(kind);
    made.textContent = content;
    if (className) made.className = className;
    return made;
  }
  function rows(table, pairs) {
    table.replaceChildren(...pairs.map(([head, said]) => {
      const row = document.createElement("tr");
      const th = element("th", head);
      th.scope = "row";
      row.append(th, element("td", said));
      return row;
    }));
  }

  // ---- The text ----
  let numbered = "";
  function number(errors) {
    const wrong = new Set(errors.map((error) => error.line));
    const count = text.value.split("\n").length;
    by("lines").scrollTop = text.scrollTop;
    // (A page is drawn again where its elements are, changed or not.)
    const now = count + ": " + [...wrong].join(" ");
    if (now === numbered) return;
    numbered = now;
    by("lines").replaceChildren(...Array.from({ length: count }, (_, k) =>
      element("span", (k + 1) + "\n", wrong.has(k + 1) ? "bad-line" : "")));
    by("lines").scrollTop = text.scrollTop;
  }
  function place(line, column) {
    const before = text.value.split("\n").slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
    text.focus();
    text.setSelectionRange(before + column - 1, before + (text.value.split("\n")[line - 1] || "").length);
    text.scrollTop = (line - 4) * 13 * 1.45;
  }
  function showChecked({ errors, keys, values }) {
    number(errors);
    by("errors").replaceChildren(...errors.map((error) => {
      const item = document.createElement("li");
      if (error.line) {
        const go = element("button", "line " + error.line + ", column " + error.column);
        go.type = "button";
        go.addEventListener("click", () => place(error.line, error.column));
        item.append(go, ": ");
      }
      item.append(error.message + (error.hint ? " (hint: " + error.hint + ")" : ""));
      return item;
    }));
    form.show(values);
    form.complain(errors, keys);
  }

  // ---- What is seen ----
  function refuse(error) {
    if (isOld(error)) return;
    by("refusal").textContent = error ? message(error) : "";
    by("refusal").hidden = !error;
    for (const img of document.querySelectorAll(".seen img")) img.classList.toggle("old", Boolean(error));
    if (error) {
      by("verdict").textContent = "Refused";
      by("verdict").className = "fail";
      by("conclusion").textContent = "";
    }
  }
  function showMap(figure, map) {
    figure.hidden = !map;
    if (!map) return;
    const img = figure.querySelector("img");
    img.src = "data:image/png;base64," + map.png;
    img.parentElement.replaceChildren(img, ...map.letters.map(({ letter, at_percent: [left, top], colour }) => {
      const mark = element("b", letter);
      mark.ariaHidden = "true";
      Object.assign(mark.style, { left: left + "%", top: top + "%", color: colour });
      return mark;
    }));
    const scale = element("div", "", "scale");
    const ramp = element("span", "", "ramp");
    for (const stop of map.stops) {
      const part = document.createElement("i");
      part.style.background = stop;
      ramp.append(part);
    }
    scale.append(element("span", map.ticks[0]), ramp, element("span", map.ticks[map.ticks.length - 1]));
    const keys = map.keys.map((key) => {
      const shown = element("span", "", "key");
      const colour = document.createElement("i");
      colour.style.background = key.colour;
      shown.append(colour, key.text);
      return shown;
    });
    figure.querySelector(".key-of").replaceChildren(scale, ...keys);
    figure.querySelector("figcaption").textContent = map.title;
  }
  // How what is shown was made.
  const HOW = { whole: "smooth mirror", small: "smooth mirror, by the small picture", sketch: "sketch of the mirror, by the small picture" };
  function showJudged(judged, how) {
    const words = { pass: "Within the limits", fail: "Over the limits" };
    by("verdict").textContent = words[judged.verdict] || "Nothing to judge";
    by("verdict").className = judged.verdict || "";
    const fact = (wanted) => (judged.facts.find(([head]) => head === wanted) || ["", ""])[1];
    const parts = [fact("picture"), fact("part"), fact("camera"), ...judged.reasons].filter(Boolean);
    by("conclusion").textContent = "(" + HOW[how] + "): " + parts.join("; ");
    rows(by("facts"), judged.facts);
  }
  function showSeen(seen, how) {
    frame = seen.frame;
    by("column").max = frame[0] - 1;
    by("row").max = frame[1] - 1;
    showMap(by("errors-map"), seen.errors);
    showMap(by("spots-map"), seen.spots);
    showJudged(seen.judged, how);
  }
  let pictureUrl = "";
  function showPicture(url, said) {
    by("picture").src = url;
    if (pictureUrl) URL.revokeObjectURL(pictureUrl);
    pictureUrl = url.startsWith("blob:") ? url : "";
    by("size").textContent = said;
  }
  function showPreview(seen, sketch) {
    refuse(null);
    const mirror = sketch ? "a sketch of the mirror, coarser to keep up" : "the smooth mirror";
    showPicture("data:image/png;base64," + seen.picture, "Test world in " + mirror + ", without shadows; " + seen.pixels.join(" x ") + " pixels while you change it. Shadows come with the next picture, once you pause; the figures below have them.");
    showSeen(seen, sketch ? "sketch" : "small");
  }
  // What follows a change comes in one answer, and is drawn at once.
  async function follow(now, edits, sketch) {
    const begun = performance.now();
    const answer = await post("/follow", { ...source(), edits, sketch });
    if (!sketch) tookMs = performance.now() - begun;
    // (What has been typed or opened since counts.)
    if (now !== change) return;
    if (edits.length) text.value = answer.text;
    if (answer.seen) showPreview(answer.seen, sketch);
    else if (answer.error) refuse(answer.error);
    showChecked(answer);
  }
  async function whole(now) {
    try {
      const png = await post("/picture", source());
      if (now !== change) return;
      refuse(null);
      showPicture(URL.createObjectURL(png), "Test world in the mesh, with the part's shadows; as morion render --scene grid writes it.");
      const seen = await post("/estimate", source());
      if (now !== change) return;
      showSeen(seen, "whole");
      const still = await post("/still", source());
      if (now === change) showStill(still);
      if (now === change && isPartSketched) nextPart(false);
    } catch (error) {
      if (now === change) refuse(error);
    }
  }
  // The part comes after the picture, one request at a time.
  let isPartAsked = false;
  let isPartSketched = false;
  async function nextPart(sketch) {
    if (isPartAsked) return;
    isPartAsked = true;
    const now = change;
    // What is wrong with a profile the picture has told.
    const part = await post("/part", { ...source(), sketch }).catch(() => null);
    isPartAsked = false;
    isPartSketched = sketch;
    if (now !== change) nextPart(sketch);
    else if (part) showPart(part);
  }
  let stillUrl = "";
  function showStill(png) {
    const img = document.querySelector("#part3d img.still");
    if (!img) return;
    if (stillUrl) URL.revokeObjectURL(stillUrl);
    img.src = stillUrl = URL.createObjectURL(png);
  }
  function showPart(part) {
    let box = by("part3d");
    if (!box) {
      box = element("div", "", "part3d");
      box.id = "part3d";
      const still = document.createElement("img");
      still.className = "still";
      still.alt = "The part seen from above and to the right of the picture's foot";
      box.append(still);
      by("part").replaceChildren(box);
    }
    const glb = by("part-glb");
    glb.textContent = part.glb;
    by("part-size").textContent = part.size + ". Drag, or use the arrow keys, to turn it; wheel, + and - bring it nearer or farther; Home brings it back.";
    if (glb.redraw) glb.redraw();
    else drawPart();
  }

  // ---- Changes: one request at a time, of waiting ones the newest of each key ----
  const waiting = new Map();
  let isBusy = false;
  let timer = 0;
  function changed(edit) {
    if (edit) waiting.set(edit.path.join(".") + " " + (edit.index ?? ""), edit);
    clearTimeout(timer);
    work();
  }
  async function work() {
    if (isBusy) return;
    isBusy = true;
    let now;
    do {
      const edits = [...waiting.values()];
      waiting.clear();
      if (edits.length) change += 1;
      now = change;
      // (What is typed or opened is shown as it is.)
      const sketch = edits.length > 0 && tookMs > FOLLOW_MS;
      await follow(now, edits, sketch).catch(refuse);
      if (now === change) nextPart(sketch);
    } while (waiting.size || now !== change);
    isBusy = false;
    clearTimeout(timer);
    timer = setTimeout(() => whole(change), QUIET_MS);
  }

  text.addEventListener("input", () => { change += 1; number([]); changed(null); });
  text.addEventListener("scroll", () => { by("lines").scrollTop = text.scrollTop; });
  by("form").addEventListener("submit", (event) => event.preventDefault());

  // ---- A pixel ----
  const digits = (x, n) => Number(x).toFixed(n);
  const vector = (v, n) => v.map((x) => digits(x, n)).join(", ");
  async function pixel(x, y) {
    by("column").value = x;
    by("row").value = y;
    try {
      const found = await post("/pixel", { ...source(), x, y });
      const lines = [["pixel", found.x + ", " + found.y],
        ["camera ray", "from " + vector(found.ray.from_mm, 3) + " mm along " + vector(found.ray.direction, 6)]];
      if (!found.hit_mm) lines.push(["mirror", "the ray meets no mirror"]);
      else {
        lines.push(["meets the mirror at", vector(found.hit_mm, 3) + " mm"], ["azimuth", digits(found.azimuth_deg, 3) + " deg"],
          ["elevation", digits(found.elevation_deg, 3) + " deg"],
          ["pixel error", found.error_px === null ? "none: nothing is asked of it" : digits(found.error_px, 3) + " px"]);
      }
      rows(by("pixel"), lines);
    } catch (error) {
      if (!isOld(error)) rows(by("pixel"), [["pixel", message(error)]]);
    }
  }
  by("picture").addEventListener("click", (event) => {
    if (!frame) return;
    const box = by("picture").getBoundingClientRect();
    const at = (from, size, count) => Math.min(count - 1, Math.max(0, Math.floor((from / size) * count)));
    pixel(at(event.clientX - box.left, box.width, frame[0]), at(event.clientY - box.top, box.height, frame[1]));
  });
  by("ask").addEventListener("click", () => pixel(Number(by("column").value) || 0, Number(by("row").value) || 0));

  // ---- Build ----
  function showBuild(status) {
    const isRunning = status.state === "running";
    by("build").disabled = isRunning;
    by("cancel").disabled = !isRunning;
    const said = { none: "", running: "building " + status.name + "...", cancelled: "cancelled; nothing was left half-written",
      failed: status.error ? message(status.error) : "the build ended without an answer", done: "verdict: " + status.verdict };
    by("build-state").textContent = said[status.state] || "";
    by("build-state").className = status.verdict || (status.state === "failed" ? "fail" : "");
    by("progress").textContent = (status.lines || []).join("\n");
    const sentence = (reason) => typeof reason === "string" ? reason : reason.message || JSON.stringify(reason);
    by("reasons").replaceChildren(...(status.reasons || []).map((reason) => element("li", sentence(reason))));
    by("files").replaceChildren(...(status.files || []).map((file) => {
      const item = document.createElement("li");
      const link = element("a", file);
      link.href = "/files/" + encodeURIComponent(file) + "?token=" + encodeURIComponent(token);
      if (file.endsWith(".html")) { link.target = "_blank"; link.rel = "noopener noreferrer"; } else link.download = file;
      item.append(link);
      return item;
    }));
    if (isRunning) setTimeout(poll, 250);
  }
  async function poll() {
    try {
      showBuild(await ask("GET", "/build"));
    } catch (error) {
      by("build-state").textContent = message(error);
    }
  }
  const press = (path, body) => async () => {
    try {
      showBuild(await post(path, body()));
    } catch (error) {
      by("build-state").textContent = message(error);
      by("build-state").className = "fail";
    }
  };
  by("build").addEventListener("click", press("/build", source));
  by("cancel").addEventListener("click", press("/cancel", () => ({})));

  // ---- Begin ----
  by("save").addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text.value], { type: "application/toml" }));
    link.download = name + ".toml";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  function open(found) {
    name = found.name;
    text.value = found.text;
    by("name").textContent = name;
    change += 1;
    changed(null);
  }
  by("shipped").addEventListener("change", async (event) => {
    if (!event.target.value) return;
    try {
      open(await post("/open", { name: event.target.value }));
    } catch (error) {
      refuse(error);
    }
  });
  post("/start").then((start) => {
    form = new ProfileForm(by("form"), start.form, changed);
    for (const known of start.shipped) by("shipped").append(new Option(known, known));
    open(start);
    poll();
  }).catch(refuse);
})();
