//! The text of an exchange structure (ISO 10303-21): tokens, parameters and entity instances.

use super::StepError;
use std::collections::BTreeMap;

/// Lists within lists up to which a file is read: geometry has three.
const MOST_DEPTH: usize = 16;

/// A parameter of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Parameter {
    /// `$` or `*`.
    Absent,
    /// An integer or a real.
    Number(f64),
    /// A string or a binary, as it stands between its quotes.
    Text(String),
    /// An enumeration without its dots.
    Enumeration(String),
    /// The number of an instance.
    Reference(u64),
    /// A list.
    List(Vec<Parameter>),
    /// A parameter with its type, such as `LENGTH_MEASURE(1.E-7)`.
    Typed(String, Vec<Parameter>),
}

/// A keyword with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Record {
    pub keyword: String,
    pub parameters: Vec<Parameter>,
}

/// An entity instance: one record, or the several of a complex one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Instance {
    /// Its line in the file, from 1.
    pub line: usize,
    pub records: Vec<Record>,
}

/// The instances of all data sections, by their numbers.
#[derive(Debug, Clone, Default)]
pub(super) struct Exchange {
    pub instances: BTreeMap<u64, Instance>,
}

impl Exchange {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// [`StepError`] with the line at which the text departs from the syntax.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, StepError> {
        let mut parser = Parser { bytes, at: 0, line: 1 };
        let mut exchange = Self::default();
        if parser.word()? != "ISO-10303-21" {
            return Err(StepError::at(1, "no STEP file: it does not begin with ISO-10303-21;"));
        }
        parser.expect(b';')?;
        loop {
            let word = parser.word()?;
            match word.as_str() {
                "END-ISO-10303-21" => break,
                "DATA" => {
                    if parser.peek() == Some(b'(') {
                        parser.list(0)?;
                    }
                    parser.expect(b';')?;
                    parser.data(&mut exchange)?;
                }
                "HEADER" => {
                    parser.expect(b';')?;
                    parser.header()?;
                }
                _ => return Err(parser.fault(format!("unknown section {word}"))),
            }
        }
        Ok(exchange)
    }
}

/// Reads tokens one after the other.
struct Parser<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl Parser<'_> {
    fn fault(&self, fault: impl Into<String>) -> StepError {
        StepError::at(self.line, fault)
    }

    /// The next byte that is neither space nor comment; it stays.
    fn peek(&mut self) -> Option<u8> {
        loop {
            match *self.bytes.get(self.at)? {
                b'\n' => (self.line, self.at) = (self.line + 1, self.at + 1),
                byte if byte.is_ascii_whitespace() || byte < b' ' => self.at += 1,
                b'/' if self.bytes.get(self.at + 1) == Some(&b'*') => {
                    let rest = &self.bytes[self.at + 2..];
                    let length = rest.windows(2).position(|pair| pair == b"*/");
                    let end = length.map_or(self.bytes.len(), |n| self.at + n + 4);
                    let comment = &self.bytes[self.at..end];
                    self.line += comment.iter().filter(|byte| **byte == b'\n').count();
                    self.at = end;
                }
                byte => return Some(byte),
            }
        }
    }

    fn expect(&mut self, wanted: u8) -> Result<(), StepError> {
        match self.peek() {
            Some(byte) if byte == wanted => {
                self.at += 1;
                Ok(())
            }
            found => {
                let found = found.map_or("the end of the file".into(), |byte| {
                    format!("'{}'", char::from(byte).escape_default())
                });
                Err(self.fault(format!("'{}' must follow, not {found}", char::from(wanted))))
            }
        }
    }

    /// Bytes as long as they are `of` a kind.
    fn run(&mut self, of: impl Fn(u8) -> bool) -> &str {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| !of(byte)).unwrap_or(rest.len());
        self.at += length;
        std::str::from_utf8(&rest[..length]).unwrap_or_default()
    }

    /// A keyword, in capitals.
    fn word(&mut self) -> Result<String, StepError> {
        self.peek();
        let is_part = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'!');
        let word = self.run(is_part).to_ascii_uppercase();
        if word.is_empty() {
            return Err(self.fault("a keyword must follow"));
        }
        Ok(word)
    }

    /// Passes over the header's records.
    fn header(&mut self) -> Result<(), StepError> {
        while self.word()? != "ENDSEC" {
            self.list(0)?;
            self.expect(b';')?;
        }
        self.expect(b';')
    }

    /// Reads the instances of a data section.
    fn data(&mut self, exchange: &mut Exchange) -> Result<(), StepError> {
        while self.peek() == Some(b'#') {
            let line = self.line;
            let id = self.number_sign()?;
            self.expect(b'=')?;
            let records = match self.peek() {
                Some(b'(') => self.complex()?,
                _ => vec![self.record()?],
            };
            self.expect(b';')?;
            if exchange.instances.insert(id, Instance { line, records }).is_some() {
                let fault = "this number is given twice".into();
                return Err(StepError { line, entity: Some(id), fault });
            }
        }
        match self.word()?.as_str() {
            "ENDSEC" => self.expect(b';'),
            word => Err(self.fault(format!("an instance or ENDSEC must follow, not {word}"))),
        }
    }

    fn complex(&mut self) -> Result<Vec<Record>, StepError> {
        self.expect(b'(')?;
        let mut records = Vec::new();
        while self.peek() != Some(b')') {
            records.push(self.record()?);
        }
        self.expect(b')')?;
        Ok(records)
    }

    fn record(&mut self) -> Result<Record, StepError> {
        Ok(Record { keyword: self.word()?, parameters: self.list(0)? })
    }

    /// `#` and a number.
    fn number_sign(&mut self) -> Result<u64, StepError> {
        self.expect(b'#')?;
        let digits = self.run(|byte| byte.is_ascii_digit());
        let id = digits.parse();
        id.map_err(|_| self.fault("'#' must be followed by a number of at most 19 digits"))
    }

    /// Parameters in parentheses, `depth` lists within others.
    fn list(&mut self, depth: usize) -> Result<Vec<Parameter>, StepError> {
        if depth > MOST_DEPTH {
            return Err(self.fault(format!("lists within lists more than {MOST_DEPTH} deep")));
        }
        self.expect(b'(')?;
        let mut parameters = Vec::new();
        if self.peek() == Some(b')') {
            self.at += 1;
            return Ok(parameters);
        }
        loop {
            parameters.push(self.parameter(depth)?);
            match self.peek() {
                Some(b',') => self.at += 1,
                _ => break,
            }
        }
        self.expect(b')')?;
        Ok(parameters)
    }

    fn parameter(&mut self, depth: usize) -> Result<Parameter, StepError> {
        Ok(match self.peek() {
            Some(b'$' | b'*') => {
                self.at += 1;
                Parameter::Absent
            }
            Some(b'#') => Parameter::Reference(self.number_sign()?),
            Some(b'(') => Parameter::List(self.list(depth + 1)?),
            Some(b'\'') => Parameter::Text(self.text()?),
            Some(b'"') => {
                self.at += 1;
                let binary = self.run(|byte| byte.is_ascii_hexdigit()).to_owned();
                self.expect(b'"')?;
                Parameter::Text(binary)
            }
            Some(b'.') => {
                self.at += 1;
                let word = self.word()?;
                self.expect(b'.')?;
                Parameter::Enumeration(word)
            }
            Some(b'+' | b'-' | b'0'..=b'9') => Parameter::Number(self.number()?),
            _ => {
                let keyword = self.word()?;
                Parameter::Typed(keyword, self.list(depth + 1)?)
            }
        })
    }

    fn number(&mut self) -> Result<f64, StepError> {
        let is_part =
            |byte: u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E');
        let text = self.run(is_part).to_owned();
        let number = text.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.fault(format!("{text} is no finite number")))
    }

    /// A string; a doubled quote is one.
    fn text(&mut self) -> Result<String, StepError> {
        self.at += 1;
        let (start, line) = (self.at, self.line);
        loop {
            match self.bytes.get(self.at) {
                None => return Err(StepError::at(line, "a string without its closing quote")),
                Some(b'\'') if self.bytes.get(self.at + 1) == Some(&b'\'') => self.at += 2,
                Some(b'\'') => break,
                Some(byte) => {
                    (self.line, self.at) = (self.line + usize::from(*byte == b'\n'), self.at + 1)
                }
            }
        }
        let text = String::from_utf8_lossy(&self.bytes[start..self.at]).replace("''", "'");
        self.at += 1;
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(data: &str) -> String {
        format!(
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nENDSEC;\nDATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n"
        )
    }

    #[test]
    fn every_kind_of_parameter_is_read() {
        let text =
            file("#1=A('it''s;',.T.,$,*,-1.5E-3,7,#12,(1,(2.)),B(3.),\"0F\");\n#2=(C()D(#1));");
        let exchange = Exchange::parse(text.as_bytes()).unwrap();
        let number = Parameter::Number;
        let wanted = vec![
            Parameter::Text("it's;".into()),
            Parameter::Enumeration("T".into()),
            Parameter::Absent,
            Parameter::Absent,
            number(-1.5e-3),
            number(7.0),
            Parameter::Reference(12),
            Parameter::List(vec![number(1.0), Parameter::List(vec![number(2.0)])]),
            Parameter::Typed("B".into(), vec![number(3.0)]),
            Parameter::Text("0F".into()),
        ];
        assert_eq!(exchange.instances[&1].records[0].parameters, wanted);
        let keywords = |id| exchange.instances[&id].records.iter().map(|r| &*r.keyword).collect();
        let complex: Vec<&str> = keywords(2);
        assert_eq!((complex, exchange.instances[&2].line), (vec!["C", "D"], 7));
    }

    #[test]
    fn comments_and_line_breaks_stand_anywhere() {
        let exchange =
            Exchange::parse(file("/* #9=\n */ #1 =\n A ( /*,*/ 1. ,\n2 ) ;").as_bytes()).unwrap();
        assert_eq!(exchange.instances[&1].line, 7);
        assert_eq!(exchange.instances[&1].records[0].parameters.len(), 2);
    }

    #[test]
    fn faults_have_their_line() {
        for (data, fault) in [
            ("#1=A(1.;", "line 6: ')' must follow, not ';'"),
            ("#1=A(1);\n#1=B();", "line 7: #1: this number is given twice"),
            ("#1=A('x);", "line 6: a string without its closing quote"),
            ("#1=A(1E999);", "line 6: 1E999 is no finite number"),
            (
                "#99999999999999999999=A();",
                "line 6: '#' must be followed by a number of at most 19 digits",
            ),
            ("#1=A(%);", "line 6: a keyword must follow"),
        ] {
            assert_eq!(Exchange::parse(file(data).as_bytes()).unwrap_err().to_string(), fault);
        }
        let deep = format!("#1=A({}", "(".repeat(100_000));
        let fault = Exchange::parse(file(&deep).as_bytes()).unwrap_err();
        assert_eq!(fault.to_string(), "line 6: lists within lists more than 16 deep");
        for end in 0..file("#1=A(1.,'x',(#2));").len() - 2 {
            assert!(
                Exchange::parse(&file("#1=A(1.,'x',(#2));").as_bytes()[..end]).is_err(),
                "{end}"
            );
        }
    }
}
