//! The description of the interface as a page for people: written from `/openapi.json` by the
//! service itself, so that it needs no script, loads nothing from elsewhere, and says what this
//! version does.

use std::fmt::Write as _;
use std::sync::LazyLock;

use axum::Router;
use axum::http::header;
use axum::routing::get;
use serde_json::{Map, Value};

use super::openapi;
use super::query::values;
use super::service::Shared;

/// Where a schema's reference leads.
const SCHEMA: &str = "#/components/schemas/";

static PAGE: LazyLock<String> =
    LazyLock::new(|| page(&serde_json::from_str(&openapi::JSON).unwrap_or_default()));

pub(super) fn routes() -> Router<Shared> {
    let html = [(header::CONTENT_TYPE, "text/html; charset=utf-8")];
    let css = [(header::CONTENT_TYPE, "text/css; charset=utf-8")];
    Router::new()
        .route("/docs", get(async move || (html, PAGE.as_str())))
        .route("/docs.css", get(async move || (css, include_str!("docs/docs.css"))))
}

fn page(api: &Value) -> String {
    let info = &api["info"];
    let title = escaped(text(&info["title"]));
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}: for programs</title>\n\
         <link rel=\"icon\" href=\"icon.svg\">\n<link rel=\"stylesheet\" href=\"look.css\">\n\
         <link rel=\"stylesheet\" href=\"docs.css\">\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n\
         <nav><a href=\"./\">For people</a> <a href=\"openapi.json\">openapi.json</a></nav>\n</header>\n<main>\n{}",
        prose(text(&info["description"]))
    );
    let operations = operations(api);
    let tags = || api["tags"].as_array().into_iter().flatten();
    out += "<table class=\"overview\">\n";
    for tag in tags() {
        for of in operations.iter().filter(|of| of.has_tag(tag)) {
            let (name, summary) = (of.name(), escaped(text(&of.value["summary"])));
            let _ = writeln!(out, "<tr><td><a href=\"#{}\"><code>{name}</code></a><td>{summary}", of.id());
        }
    }
    out += "</table>\n";
    for tag in tags() {
        let _ =
            writeln!(out, "<h2>{}</h2>\n{}", escaped(text(&tag["name"])), prose(text(&tag["description"])));
        for of in operations.iter().filter(|of| of.has_tag(tag)) {
            of.write(&mut out);
        }
    }
    out += "<h2>Records</h2>\n";
    for (name, schema) in entries(&api["components"]["schemas"]) {
        write_schema(name, schema, &mut out);
    }
    out + "</main>\n</body>\n</html>\n"
}

/// A method of a path.
struct Operation<'a> {
    path: &'a str,
    method: String,
    value: &'a Value,
}

fn operations(api: &Value) -> Vec<Operation<'_>> {
    let paths = entries(&api["paths"]);
    let each = paths.flat_map(|(path, methods)| {
        entries(methods).map(move |(method, value)| Operation { path, method: method.to_uppercase(), value })
    });
    each.collect()
}

impl Operation<'_> {
    fn has_tag(&self, tag: &Value) -> bool {
        self.value["tags"].as_array().is_some_and(|tags| tags.contains(&tag["name"]))
    }

    fn id(&self) -> String {
        escaped(text(&self.value["operationId"]))
    }

    fn name(&self) -> String {
        format!("{} {}", self.method, escaped(self.path))
    }

    fn write(&self, out: &mut String) {
        let (name, summary) = (self.name(), escaped(text(&self.value["summary"])));
        let _ = writeln!(out, "<article id=\"{}\">\n<h3><code>{name}</code> {summary}</h3>", self.id());
        *out += &prose(text(&self.value["description"]));
        let body = &self.value["requestBody"];
        if !body.is_null() {
            let (meaning, kinds) = (prose(text(&body["description"])), contents(body).join(" or "));
            let _ = writeln!(out, "<h4>Body</h4>\n{meaning}<p>{kinds}</p>");
        }
        let parameters = self.value["parameters"].as_array().into_iter().flatten();
        let mut parameters = parameters.peekable();
        if parameters.peek().is_some() {
            *out += "<h4>Parameters</h4>\n<table>\n<tr><th>Name<th>Value<th>Meaning\n";
        }
        let has_parameters = parameters.peek().is_some();
        for parameter in parameters {
            let (name, schema) = (escaped(text(&parameter["name"])), &parameter["schema"]);
            let meaning = inline(text(&parameter["description"]));
            let _ = writeln!(out, "<tr><td><code>{name}</code><td>{}<td>{meaning}", inline(&values(schema)));
        }
        if has_parameters {
            *out += "</table>\n";
        }
        *out += "<h4>Answers</h4>\n<table>\n<tr><th>Status<th>Meaning<th>Body\n";
        for (status, response) in entries(&self.value["responses"]) {
            let (meaning, bodies) = (inline(text(&response["description"])), contents(response).join("; "));
            let _ = writeln!(out, "<tr><td>{}<td>{meaning}<td>{bodies}", escaped(status));
        }
        *out += "</table>\n</article>\n";
    }
}

/// The media types that a request or an answer may have, each with what it then holds.
fn contents(of: &Value) -> Vec<String> {
    let content = |(kind, content): (&str, &Value)| match &content["schema"] {
        Value::Null => format!("<code>{}</code>", escaped(kind)),
        schema => format!("<code>{}</code>: {}", escaped(kind), kind_of(schema)),
    };
    entries(&of["content"]).map(content).collect()
}

fn write_schema(name: &str, schema: &Value, out: &mut String) {
    let id = escaped(name);
    let _ = writeln!(out, "<details id=\"{id}\">\n<summary><code>{id}</code></summary>");
    *out += &prose(text(&schema["description"]));
    let properties = || entries(&schema["properties"]);
    if properties().next().is_some() {
        *out += "<table>\n<tr><th>Key<th>Value<th>Meaning\n";
        for (key, value) in properties() {
            let (key, meaning) = (escaped(key), inline(text(&value["description"])));
            let _ = writeln!(out, "<tr><td><code>{key}</code><td>{}<td>{meaning}", kind_of(value));
        }
        *out += "</table>\n";
    } else {
        let _ = writeln!(out, "<p>{}</p>", kind_of(schema));
    }
    *out += "</details>\n";
}

/// What values a schema is of, with links to the schemas that it names.
fn kind_of(schema: &Value) -> String {
    if let Some(name) = schema["$ref"].as_str().and_then(|name| name.strip_prefix(SCHEMA)) {
        let name = escaped(name);
        return format!("<a href=\"#{name}\">{name}</a>");
    }
    for (of, word) in [("oneOf", " or "), ("anyOf", " or "), ("allOf", " with ")] {
        if let Some(each) = schema[of].as_array() {
            return each.iter().map(kind_of).collect::<Vec<_>>().join(word);
        }
    }
    if let Some(items) = schema.get("prefixItems").and_then(Value::as_array) {
        let each: Vec<String> = items.iter().map(kind_of).collect();
        return format!("array of {}", each.join(", "));
    }
    if let Some(named) = schema["enum"].as_array() {
        let each: Vec<String> =
            named.iter().map(|value| format!("<code>{}</code>", escaped(&value.to_string()))).collect();
        return each.join(" or ");
    }
    let of = |name: &str| match name {
        "array" => format!("array of {}", kind_of(&schema["items"])),
        name => escaped(name),
    };
    match &schema["type"] {
        Value::String(name) => of(name),
        Value::Array(names) => {
            names.iter().filter_map(Value::as_str).map(of).collect::<Vec<_>>().join(" or ")
        }
        _ => "any value".into(),
    }
}

fn entries(value: &Value) -> impl Iterator<Item = (&str, &Value)> {
    value.as_object().into_iter().flat_map(Map::iter).map(|(name, value)| (name.as_str(), value))
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Paragraphs, and examples where all lines of one are indented.
fn prose(text: &str) -> String {
    let mut out = String::new();
    for paragraph in text.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty()) {
        let _ = match paragraph.lines().all(|line| line.starts_with("    ")) {
            true => writeln!(out, "<pre>{}</pre>", escaped(paragraph.replace("\n    ", "\n").trim_start())),
            false => writeln!(out, "<p>{}</p>", inline(paragraph)),
        };
    }
    out
}

/// Text in which backticks mark code.
fn inline(text: &str) -> String {
    let pieces = text.split('`').enumerate().map(|(at, piece)| match at % 2 {
        0 => escaped(piece),
        _ => format!("<code>{}</code>", escaped(piece)),
    });
    pieces.collect()
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            letter => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_and_record_is_on_the_page_and_every_link_leads_somewhere() {
        let api: Value = serde_json::from_str(&openapi::JSON).unwrap();
        for of in operations(&api) {
            assert!(PAGE.contains(&format!("<h3><code>{}</code> ", of.name())), "{}", of.path);
            for text in ["summary", "description", "operationId"] {
                assert!(of.value[text].as_str().is_some_and(|text| !text.is_empty()), "{}: {text}", of.path);
            }
            assert!(!text(&of.value["summary"]).contains(of.path), "a summary says what a path does");
        }
        let values_of = |name: &str| {
            let attribute = format!("{name}=\"");
            let values = PAGE.split(attribute.as_str()).skip(1);
            values.map(|rest| rest.split('"').next().unwrap()).collect::<Vec<_>>()
        };
        for target in values_of("href").iter().filter_map(|target| target.strip_prefix('#')) {
            assert!(PAGE.contains(&format!("id=\"{target}\"")), "{target}");
        }
        let loaded = PAGE.split("<link").skip(1).map(|rest| rest.split('>').next().unwrap());
        for source in values_of("src").into_iter().chain(loaded) {
            assert!(!source.contains("//"), "{source} is loaded from elsewhere");
        }
    }

    #[test]
    fn text_is_text() {
        assert_eq!(
            prose("a <b> `c&d`\n\n    e\n    <f>"),
            "<p>a &lt;b&gt; <code>c&amp;d</code></p>\n<pre>e\n&lt;f&gt;</pre>\n"
        );
    }
}
