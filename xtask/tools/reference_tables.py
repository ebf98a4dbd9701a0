"""The tables of fields in the manual, from the schema of scenarios. Where they stand the pages have

    <!-- fields: robots.link.adapter -->
    …
    <!-- end -->

Names are the fields' paths; `*` is any name. A table whose fields depend on its `kind` has a block for what all kinds have, `… place` for
the fields of a place, and `… kind = NAME` for those of a kind. The rows keep their order; new ones come last.
"""

import re

BLOCK = re.compile(r"^<!-- fields: ([^\n]+) -->\n(.*?)^<!-- end -->$", re.M | re.S)
HEAD = "\n| field | type | default | range | meaning |\n|---|---|---|---|---|\n"
TOP = "top level"
# The same table in another place, which has its own block.
ELSEWHERE = ("robots.sensors.*.port.link", "robots.starts")
# Words of more than so many are on a page of their own.
MOST_WORDS = 8


def filled(page, schema, known):
    """A page with its tables as the schema has them; their names are added to those that are known."""

    def table(block):
        name, text = block.groups()
        known.append(name)
        fields = tables(schema).get(name)
        if fields is None:
            raise SystemExit(f"<!-- fields: {name} -->: the schema has no such table")
        there = re.findall(r"^\| `(\w+)` \|", text, re.M)
        order = sorted(fields, key=lambda field: (there.index(field) if field in there else len(there), field))
        return f"<!-- fields: {name} -->\n{HEAD}{''.join(row(field, fields[field]) for field in order)}\n<!-- end -->"

    return BLOCK.sub(table, page)


def missing(schema, known):
    """The tables that no page has, or more than one."""
    return [name for name in tables(schema) if known.count(name) != 1]


def tables(schema):
    """All tables of fields, by their names."""
    found = {}
    collect(schema, "", found)
    return {name: fields for name, fields in found.items() if fields and not name.startswith(ELSEWHERE)}


def collect(node, name, found):
    """Adds the tables of a node and of what is in it."""
    node = node.get("items", node)
    for way in node.get("anyOf", []) if isinstance(node, dict) else []:
        collect(way, name, found)
    if not isinstance(node, dict):
        return
    each = node.get("additionalProperties")
    if isinstance(each, dict):
        collect(each, f"{name}.*", found)
    parts = node.get("allOf", [])
    fields = node.get("properties") or (parts[0].get("properties", {}) if parts else {})
    if fields:
        found[name or TOP] = fields
    for branch in parts[1:]:
        own = {field: value for field, value in branch.get("then", {}).get("properties", {}).items() if isinstance(value, dict)}
        if own:
            kind = kind_of(branch["if"])
            found[f"{name} kind = {kind}"] = own
            fields = {**fields, **own}
    if len(parts) > 2 and "bearing_rad" in parts[1].get("properties", {}):
        found[f"{name} place"] = parts[1]["properties"]
        fields = {**fields, **parts[1]["properties"]}
    for field, value in fields.items():
        if isinstance(value, dict) and f"{name}.{field}" not in found:
            collect(value, f"{name}.{field}".lstrip("."), found)


def kind_of(condition):
    """The kind of which a table is under this condition."""
    condition = condition.get("anyOf", [condition])[0]
    return condition["properties"]["kind"]["enum"][0]


def row(name, field):
    """A row of a table."""
    text = field.get("x-manual") or field.get("description", "")
    parts = {}
    for mark in ("Range", "Default", "Type"):
        text, found, behind = text.partition(f" {mark}: ")
        parts[mark] = behind.removesuffix(".") if found else ""
    cells = [f"`{name}`", parts["Type"] or ("string" if name == "preset" else type_of(field)), parts["Default"] or "none", parts["Range"], text]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells).replace("|  |", "| |") + " |\n"


def type_of(field):
    """The words of the manual for a type."""
    if "anyOf" in field:
        return " or ".join(dict.fromkeys(type_of(way) for way in field["anyOf"]))
    words = field.get("enum", [])
    if words and isinstance(words[0], str):
        return either([f'`"{word}"`' for word in words]) if len(words) <= MOST_WORDS else "string"
    if field.get("type") == "array":
        items = field["items"]
        of_each = type_of(items[0] if isinstance(items, list) else items)
        number = f"{field['minItems']} " if field.get("minItems") == field.get("maxItems", -1) else ""
        return f"list of {number}{re.sub('^(list|[a-z]+$)', lambda word: word[0] + 's', of_each)}"
    if field.get("type") == "object" or "allOf" in field:
        each = field.get("additionalProperties")
        return "table of tables" if isinstance(each, dict) and "anyOf" not in each else "table"
    return field.get("type", "any")


def either(words):
    """Words with an `or` before the last."""
    return " or ".join(filter(None, [", ".join(words[:-1]), words[-1]]))
