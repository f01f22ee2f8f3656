//! The layers of docs/layers.md, held against the sources: which module imports which is read from the paths that
//! begin with `crate`, `super`, `self` or a child's name. What only tests use does not count.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// From the ground up. A module imports modules of lower layers only, none beside it.
const LAYERS: [&[&str]; 8] = [
    &["error", "matrix"],
    &["rotation", "job", "memory"],
    &["geometry"],
    &["mesh", "linear"],
    &["options", "symmetry"],
    &["operators", "riding", "strain_limits"],
    &["stitch"],
    &["pose", "transfer", "inbetween", "picture"],
];

const BEGIN: &str = "<!-- imports of the core -->";
const END: &str = "<!-- end of the imports of the core -->";

type Module = Vec<String>;

/// The sources without their tests: tokens and imports of every file, by its module's path.
struct Sources {
    tokens: BTreeMap<Module, Vec<String>>,
    imports: BTreeMap<Module, BTreeSet<Module>>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn name(module: &[String]) -> String {
    module.join("::")
}

fn layer(module: &str) -> usize {
    let of = |layer: &&[&str]| layer.contains(&module);
    LAYERS.iter().position(of).unwrap_or_else(|| panic!("`{module}` stands in no layer: give it one here"))
}

impl Sources {
    fn read() -> Self {
        let mut tokens = BTreeMap::new();
        let mut tests = BTreeSet::new();
        let mut pending = vec![folder()];
        while let Some(path) = pending.pop() {
            if path.is_dir() {
                pending.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
                continue;
            }
            let relative = path.strip_prefix(folder()).unwrap().with_extension("");
            let mut module: Module = relative.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
            module.retain(|part| part != "mod" && part != "lib");
            let (kept, left_out) = without_tests(&tokens_of(&fs::read_to_string(path).unwrap()));
            tests.extend(left_out.into_iter().map(|child| [module.clone(), vec![child]].concat()));
            tokens.insert(module, kept);
        }
        tokens.retain(|module, _| !tests.contains(module));
        let mut sources = Self { tokens, imports: BTreeMap::new() };
        let files = sources.tokens.iter().filter(|(module, _)| !module.is_empty());
        sources.imports = files.map(|(m, tokens)| (m.clone(), sources.imports_of(m, tokens))).collect();
        assert!(sources.imports.len() > 20, "the sources are not where this test looks for them");
        sources
    }

    /// The modules that one file names, each by the path of its own file.
    fn imports_of(&self, module: &Module, tokens: &[String]) -> BTreeSet<Module> {
        let mut found = BTreeSet::new();
        for (base, path) in self.paths(module, tokens) {
            let whole = [base, path].concat();
            let file =
                (1..=whole.len()).rev().map(|n| whole[..n].to_vec()).find(|m| self.tokens.contains_key(m));
            found.extend(file.or_else(|| self.reexported(whole.first()?)).filter(|file| file != module));
        }
        found
    }

    /// Every path of a file as the module that it starts from, and the names that follow.
    fn paths(&self, module: &Module, tokens: &[String]) -> Vec<(Module, Module)> {
        let mut found = Vec::new();
        for at in 0..tokens.len().saturating_sub(1) {
            let before = if at == 0 { "" } else { &tokens[at - 1] };
            if tokens[at + 1] != "::" || ["::", ".", "in"].contains(&before) {
                continue;
            }
            let child = [module.clone(), vec![tokens[at].clone()]].concat();
            let (mut base, mut next) = match tokens[at].as_str() {
                "crate" => (vec![], at + 2),
                "self" => (module.clone(), at + 2),
                "super" => (module[..module.len() - 1].to_vec(), at + 2),
                _ if self.tokens.contains_key(&child) => (child, at + 2),
                _ => continue,
            };
            while tokens[next] == "super" {
                base.pop();
                next += 2;
            }
            // A macro fills these in where it is used, with names that stand there.
            if tokens[next..].starts_with(&["{".to_owned(), "$".to_owned()]) {
                continue;
            }
            let mut paths = Vec::new();
            tree(tokens, &mut next, vec![], &mut paths);
            found.extend(paths.into_iter().map(|path| (base.clone(), path)));
        }
        found
    }

    /// The module whose `name` the crate's door hands on.
    fn reexported(&self, name: &str) -> Option<Module> {
        let door = Module::new();
        let of = |(base, path): (Module, Module)| (path.last()? == name).then_some(base);
        self.paths(&door, &self.tokens[&door]).into_iter().find_map(of)
    }

    fn file(&self, module: &Module) -> String {
        let base = folder().join(module.iter().collect::<PathBuf>());
        let file = if base.is_dir() { base.join("mod.rs") } else { base.with_extension("rs") };
        file.strip_prefix(folder()).unwrap().display().to_string()
    }

    /// The imports of each module of the first level.
    fn table(&self) -> BTreeMap<String, BTreeSet<String>> {
        let mut table: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (module, imports) in &self.imports {
            let others = imports.iter().map(|import| &import[0]).filter(|import| **import != module[0]);
            table.entry(module[0].clone()).or_default().extend(others.cloned());
        }
        table
    }
}

/// Identifiers, `::` and single characters; comments and literals are left out.
fn tokens_of(source: &str) -> Vec<String> {
    let text: Vec<char> = source.chars().collect();
    let at = |i: usize| text.get(i).copied().unwrap_or('\0');
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut tokens, mut i) = (Vec::new(), 0);
    while i < text.len() {
        let begin = i;
        match at(i) {
            '/' if at(i + 1) == '/' => i += text[i..].iter().take_while(|c| **c != '\n').count(),
            '/' if at(i + 1) == '*' => {
                i += 2;
                while i < text.len() && (at(i), at(i + 1)) != ('*', '/') {
                    i += 1;
                }
                i += 2;
            }
            '"' => {
                i += 1;
                while i < text.len() && at(i) != '"' {
                    i += if at(i) == '\\' { 2 } else { 1 };
                }
                i += 1;
            }
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => {
                i += 2;
                i += text[i..].iter().take_while(|c| **c != '\'').count() + 1;
            }
            ':' if at(i + 1) == ':' => {
                tokens.push("::".to_owned());
                i += 2;
            }
            c if word(c) => {
                i += text[i..].iter().take_while(|c| word(**c)).count();
                tokens.push(text[begin..i].iter().collect());
            }
            c => {
                tokens.extend((!c.is_whitespace()).then(|| c.to_string()));
                i += 1;
            }
        }
    }
    tokens
}

/// The tokens without what stands under `#[cfg(test)]`, and the names of the files that it brings in.
fn without_tests(tokens: &[String]) -> (Vec<String>, Vec<String>) {
    let (mut kept, mut files, mut i) = (Vec::new(), Vec::new(), 0);
    while i < tokens.len() {
        if !tokens[i..].iter().map(String::as_str).take(7).eq(["#", "[", "cfg", "(", "test", ")", "]"]) {
            kept.push(tokens[i].clone());
            i += 1;
            continue;
        }
        let begin = i + 7;
        i = begin;
        let mut depth = 0;
        loop {
            match tokens[i].as_str() {
                "{" => depth += 1,
                "}" => depth -= 1,
                _ => {}
            }
            i += 1;
            let block = tokens[i - 1] == "}" && tokens.get(i).is_none_or(|next| next != ";");
            if depth == 0 && (block || tokens[i - 1] == ";") {
                break;
            }
        }
        let item = &tokens[begin..i];
        if let Some(at) = item.iter().position(|token| token == "mod").filter(|_| item[item.len() - 1] == ";")
        {
            files.push(item[at + 1].clone());
        }
    }
    (kept, files)
}

/// The paths of a use tree, or the one path of an expression, from the token `at` on.
fn tree(tokens: &[String], at: &mut usize, base: Module, found: &mut Vec<Module>) {
    let mut path = base;
    loop {
        match tokens[*at].as_str() {
            "{" => {
                while tokens[*at] != "}" {
                    *at += 1;
                    if tokens[*at] != "}" {
                        tree(tokens, at, path.clone(), found);
                    }
                    *at += tokens[*at..].iter().take_while(|t| *t != "," && *t != "}").count();
                }
                *at += 1;
                return;
            }
            "*" | "<" => break,
            "self" => {}
            word => path.push(word.to_owned()),
        }
        *at += 1;
        if tokens.get(*at).is_none_or(|token| token != "::") {
            break;
        }
        *at += 1;
    }
    found.push(path);
}

#[test]
fn paths_are_read_as_rust_reads_them() {
    let source = "use crate::{Mesh, linear::{self, Columns as C, factor::*}}; // crate::pose\n
        #[cfg(test)] mod tests { use crate::transfer; fn f() { let x = \"}\"; } }
        #[cfg(test)] mod testing;
        #[cfg(test)] use crate::{inbetween};
        fn g<'a>(x: super::super::stitch::Stitcher) -> char { self::h::<'a>(x); '\\'' }";
    let (tokens, files) = without_tests(&tokens_of(source));
    assert_eq!(files, ["testing"]);
    let sources = Sources { tokens: BTreeMap::new(), imports: BTreeMap::new() };
    let module = ["transfer", "fit", "energy"].map(str::to_owned).to_vec();
    let whole = |(base, path): (Module, Module)| name(&[base, path].concat());
    let found: Vec<String> = sources.paths(&module, &tokens).into_iter().map(whole).collect();
    let expected = [
        "Mesh",
        "linear",
        "linear::Columns",
        "linear::factor",
        "transfer::stitch::Stitcher",
        "transfer::fit::energy::h",
    ];
    assert_eq!(found, expected);
}

#[test]
fn no_arrow_points_up_or_to_the_side() {
    let sources = Sources::read();
    let mut wrong = Vec::new();
    for (module, imports) in &sources.imports {
        for import in imports {
            if import[0] != module[0] && layer(&import[0]) >= layer(&module[0]) {
                wrong.push(format!("{} takes {}", sources.file(module), name(import)));
            }
        }
    }
    assert!(wrong.is_empty(), "imports from a layer that is not below:\n  {}", wrong.join("\n  "));
}

#[test]
fn children_do_not_import_their_door() {
    let sources = Sources::read();
    let mut wrong = Vec::new();
    for (module, imports) in &sources.imports {
        for door in imports.iter().filter(|import| module.starts_with(import)) {
            wrong.push(format!("{} takes {}", sources.file(module), sources.file(door)));
        }
    }
    assert!(wrong.is_empty(), "a folder's mod.rs opens to the outside only:\n  {}", wrong.join("\n  "));
}

#[test]
fn no_files_import_each_other() {
    fn reach<'a>(sources: &'a Sources, from: &'a Module) -> BTreeSet<&'a Module> {
        let mut seen = BTreeSet::new();
        let mut pending = vec![from];
        while let Some(module) = pending.pop() {
            // What a child takes from its door is told by the test above.
            let others = sources.imports[module].iter().filter(|import| !module.starts_with(import));
            pending.extend(others.filter(|import| seen.insert(*import)));
        }
        seen
    }
    let sources = Sources::read();
    let reached: BTreeMap<_, _> = sources.imports.keys().map(|m| (m, reach(&sources, m))).collect();
    let mut rings = BTreeSet::new();
    for (module, others) in &reached {
        let ring: Vec<String> = (others.iter().filter(|other| reached[*other].contains(module)))
            .map(|other| sources.file(other))
            .collect();
        if !ring.is_empty() {
            rings.insert(ring.join(", "));
        }
    }
    assert!(rings.is_empty(), "files that import each other, by others or at once:\n  {rings:#?}");
}

#[test]
fn only_linear_knows_the_columns_of_a_solve() {
    let sources = Sources::read();
    let outside = sources.tokens.iter().filter(|(module, _)| module.first().is_some_and(|m| m != "linear"));
    let knows = outside.filter(|(_, tokens)| tokens.iter().any(|token| token == "Columns"));
    let files: Vec<String> = knows.map(|(module, _)| sources.file(module)).collect();
    assert!(files.is_empty(), "linear::Columns is named in\n  {}", files.join("\n  "));
}

#[test]
fn the_architecture_shows_which_module_imports_which() {
    let table = Sources::read().table();
    let mut lines = vec!["| module | layer | imports |".to_owned(), "|---|---|---|".to_owned()];
    for (height, modules) in LAYERS.iter().enumerate().rev() {
        for module in modules.iter().filter(|module| table.contains_key(**module)) {
            let mut imports: Vec<&str> = table[*module].iter().map(String::as_str).collect();
            imports.sort_by_key(|import| std::cmp::Reverse(layer(import)));
            lines.push(format!("| `{module}` | {} | {} |", height + 1, imports.join(", ")));
        }
    }
    let made = lines.join("\n");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/layers.md");
    let text = fs::read_to_string(file).unwrap().replace('\r', "");
    let shown = text.split_once(BEGIN).and_then(|(_, rest)| Some(rest.split_once(END)?.0.trim()));
    assert!(shown == Some(made.as_str()), "docs/layers.md should have\n\n{BEGIN}\n\n{made}\n\n{END}\n");
}
