"""Messages as Python says them: calls and arguments, where the command has verbs and options."""

from __future__ import annotations

import html
import re
import shlex

#: Options whose argument in Python has another name.
_OTHERWISE = {"input": "record", "records": "manifest", "o": "out"}
#: Options that are True or False.
_SWITCHES = ("force", "resume")
#: What is of the command between backticks, or in the code of a page: a verb, an option, or both.
_WORDS = "((?:borescope )?[a-z]+(?: [^`<]*)?|--[a-z][^`<]*|-o [^`<]*)"
_SPOKEN = re.compile(f"`{_WORDS}`")
_IN_PAGE = re.compile(f"<code>{_WORDS}</code>")
#: A whole command that stands alone, such as behind `Next:`.
_COMMAND = re.compile(r"(?<![\w`/.-])borescope (?:check|compare|diagnose|suggest|improve|add|isolability|calibrate|campaign|history|simulate) [^\n`<]+")
#: The rig file that a call writes, which is its result.
_NEW = ("new.toml", "better.toml", "calibrated.toml", "NEW.toml")


def in_python(text: str) -> str:
    """A text of the command with its verbs and options as calls and arguments; what Python has not stays as it is."""
    if "borescope " not in text and "--" not in text and "`-o" not in text:
        return text
    text = _SPOKEN.sub(lambda found: f"`{_spoken(found[1])}`", text)
    return _COMMAND.sub(lambda found: _call(found[0]) or found[0], text)


def page_in_python(page: str) -> str:
    """The same for a page, whose code is between tags."""
    page = _IN_PAGE.sub(lambda found: f"<code>{html.escape(_spoken(html.unescape(found[1])), quote=False)}</code>", page)
    page = page.replace("--input RECORD", "<code>record</code>")
    return _COMMAND.sub(lambda found: html.escape(_call(html.unescape(found[0])) or "", quote=False) or found[0], page)


def _spoken(words: str) -> str:
    if words.startswith("-"):
        return _option(words)
    verb, _, rest = words.removeprefix("borescope ").partition(" ")
    if not words.startswith("borescope ") and not rest.startswith("-"):
        return words
    if verb == "diagnose" and "--window" in rest:
        return "rig.monitor(record, window)"
    if called := _call(words):
        return called
    plain = {
        "calibrate": "rig.calibrate(records)",
        "add": "rig.add(effect)",
        "campaign": "rig.campaign(cases)",
        "components": "bs.components()",
        "effects": "bs.effects()",
        "export": "Store.to_pandas()",
        "isolability": "rig.isolability()",
        "simulate": "rig.simulate()",
        "suggest": "rig.suggest(record)",
        "fleet": "bs.fleet(store)",
        "diagnose": f"rig.diagnose(record{', ' + _option(rest) if rest.startswith('--') else ''})",
        "check": "rig.check(record)",
        "compare": "rig.compare(record)",
        "improve": "rig.improve(fit, check)",
    }
    if verb == "diagnose" and rest.startswith("--merge"):
        return words
    return plain.get(verb, words)


def _option(words: str) -> str:
    name, _, value = words.lstrip("-").partition(" ")
    name = _OTHERWISE.get(name, name)
    if name == "set" and "=" in value:
        id, _, given = value.partition("=")
        return f'set={{"{id}": "{given}"}}'
    if name in _SWITCHES:
        return f"{name}=True"
    if not value or value.isupper():
        return name
    return f"{name}={value}" if re.fullmatch(r"[-+.\de]+", value) else f'{name}="{value}"'


def _call(command: str) -> str | None:
    """A whole command as a call; none where Python has no such call."""
    try:
        _, verb, *words = shlex.split(command if command.startswith("borescope ") else f"borescope {command}")
    except ValueError:
        return None
    given: list[str] = []
    options: dict[str, str] = {}
    while words:
        word = words.pop(0)
        if not word.startswith("-"):
            given.append(word)
        elif not words:
            return None
        else:
            options[word.lstrip("-")] = words.pop(0)
    if not given:
        return None
    new = given[0].endswith(_NEW)
    rig = "result.rig" if new else "rig"

    def record(at: int) -> str:
        return "" if at >= len(given) else _record(given[at], "check" if new else "record")

    options.pop("o", None)
    match verb, sorted(options):
        case ("check" | "diagnose", []):
            return f"{rig}.{verb}({record(1)})"
        case "compare", [] | ["before"]:
            return f"{rig}.compare({record(1)})"
        case "diagnose", ["report"]:
            return f'{rig}.diagnose({record(1)}).save("{options["report"]}")'
        case "diagnose", ["store"]:
            return f'{rig}.diagnose({record(1)}, store={_file(options["store"])})'
        case "suggest", [] | ["check"]:
            check = f", {_record(options['check'], 'check')}" if options else ""
            return f"{rig}.suggest({record(1)}{check})"
        case "improve", ["check", "fit"]:
            return f"{rig}.improve({_record(options['fit'], 'record')}, {_record(options['check'], 'check')})"
        case "add", ["fit"] if len(given) > 1:
            return f'{rig}.add("{given[1]}", {_record(options["fit"], "record")})'
        case "isolability", [] | ["input"]:
            return f"{rig}.isolability({'record' if options else ''})"
        case "calibrate", []:
            return f"{rig}.calibrate([{', '.join(_record(one, 'record') for one in given[1:])}]).rig"
        case "campaign", ["cases"] | ["cases", "seed"]:
            seed = f", seed={options['seed']}" if "seed" in options else ""
            return f"{rig}.campaign({options['cases']}{seed})"
        case "history", ["store"]:
            return f"bs.history({_file(options['store'])}, {rig})"
    return None


def _record(word: str, name: str) -> str:
    """A record that the command has yet to be given keeps what it is called, in small letters."""
    return word.lower() if re.fullmatch("[A-Z_]+", word) else name


def _file(word: str) -> str:
    return "store" if word.isupper() else f'"{word}"'
