//! Verdict: whether a key that was carried over is good, deserves a look, or is bad, and why, from what one sees.

/// What is to be done about a key.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Nothing.
    #[default]
    Good,
    /// It may be right: look at it.
    Look,
    /// It has to be mended.
    Bad,
}

impl Verdict {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Look => "look",
            Self::Bad => "bad",
        }
    }
}

/// Turned over: any triangle deserves a look, as one alone makes a dent in the shading; a patch of this part of the
/// area that moves is a dark spot that no light hides.
const TURNED: [f64; 2] = [0.0, 2e-3];

/// Torn: as a part of the area that moves. A triangle in a thousand is one at a fold, where lips part; a hundredth
/// of a motion is a visible rag.
const TORN: [f64; 2] = [1e-3, 1e-2];

/// Open: what part of the way surfaces still are from each other that meet on the source. A slit of a tenth of the eye
/// shows the white in a close shot; at two fifths a blink reads as a squint.
const OPEN: [f64; 2] = [0.1, 0.4];

/// Gaps below this part of the target's diagonal, 0.1 mm on a head, are none.
const NO_GAP: f64 = 3e-4;

/// Contacts along less than this, a part of the diagonal, are chance touches: the vertices of both lids of an eye that
/// meet in a blink make up more, those at the corners of a mouth that brush as the jaw moves less.
const BRUSHED: f64 = 0.2;

/// How many times too small or too large a motion is: animators exaggerate by a third without anyone taking it for
/// another expression; at 2.5 it is another one.
const AMPLITUDE: [f64; 2] = [4.0 / 3.0, 2.5];

/// Differences of left and right, over the motion, beyond that of the source. A smile that is a fifth stronger on one
/// side reads as crooked, one of a half as a smirk.
const CROOKED: [f64; 2] = [0.2, 0.5];

/// What part of the source's motion has a counterpart. The skin moves more than what lines it, so half of it is enough to
/// make out an expression; where a tenth is left, it was made for something that the target has not.
const COVERED: [f64; 2] = [0.5, 0.1];

/// What is known about a key before it is judged.
#[derive(Debug, Clone, Copy)]
pub struct Findings {
    /// Triangles turned over, and their part of the area that moves.
    pub turned: (usize, f64),
    /// Triangles torn, and their part of the area that moves.
    pub torn: (usize, f64),
    /// How much of the target meets another surface on the source: the sum of the lengths of its contacts.
    pub along: f64,
    /// Mean distance that these are wider apart than there, a part of the diagonal.
    pub gap: f64,
    /// What part of the way they come together.
    pub closing: f64,
    /// Motion over what was asked; no more than 1 where contacts have asked for more.
    pub amplitude: f64,
    /// Difference of left and right beyond that of the source.
    pub crooked: f64,
    /// What part of the source's motion has a counterpart on the target.
    pub covered: f64,
}

impl Findings {
    /// Whether lids or lips close in this key.
    pub fn closes(&self) -> bool {
        self.along > BRUSHED
    }

    /// How bad it is that they do not close as far as on the source.
    pub fn open(&self) -> Verdict {
        let seen = self.closes() && self.gap > NO_GAP;
        if seen { grade(1.0 - self.closing, OPEN) } else { Verdict::Good }
    }
}

/// The verdict, and the reasons for it, the worst first.
pub fn judge(found: &Findings) -> (Verdict, Vec<String>) {
    let triangles = |n: usize| if n == 1 { "1 triangle".into() } else { format!("{n} triangles") };
    let off = found.amplitude.max(1.0 / found.amplitude);
    let percent = |part: f64| (100.0 * part).round();
    let only = if found.amplitude < 1.0 { "only " } else { "" };
    let mut reasons = [
        (grade(found.turned.1, TURNED), format!("{} turned over", triangles(found.turned.0))),
        (grade(found.torn.1, TORN), format!("{} torn", triangles(found.torn.0))),
        (found.open(), format!("closes only {} % of the way", percent(found.closing))),
        (
            grade(off, AMPLITUDE),
            format!("moves {only}{} % as far as on the source", percent(found.amplitude)),
        ),
        (
            grade(-found.covered, COVERED.map(|part| -part)),
            format!("only {} % of what moves on the source has a counterpart", percent(found.covered)),
        ),
        (
            grade(found.crooked, CROOKED),
            format!("left and right differ by {} % of the motion", percent(found.crooked)),
        ),
    ];
    reasons.sort_by_key(|(verdict, _)| std::cmp::Reverse(*verdict));
    let verdict = reasons[0].0;
    let told = reasons.into_iter().filter(|(verdict, _)| *verdict > Verdict::Good);
    (verdict, told.map(|(_, reason)| reason).collect())
}

fn grade(value: f64, [look, bad]: [f64; 2]) -> Verdict {
    if value > bad {
        Verdict::Bad
    } else if value > look {
        Verdict::Look
    } else {
        Verdict::Good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: Findings = Findings {
        turned: (0, 0.0),
        torn: (0, 0.0),
        along: 0.0,
        gap: 0.0,
        closing: 1.0,
        amplitude: 1.0,
        crooked: 0.0,
        covered: 1.0,
    };

    #[test]
    fn the_worst_reason_comes_first_and_decides() {
        assert_eq!(judge(&FINE), (Verdict::Good, Vec::new()));
        let one = Findings { turned: (1, 1e-5), ..FINE };
        assert_eq!(judge(&one), (Verdict::Look, vec!["1 triangle turned over".into()]));
        let closes = Findings { along: 0.5, gap: 0.01, closing: 0.55, ..one };
        let (verdict, reasons) = judge(&closes);
        assert_eq!(verdict, Verdict::Bad);
        assert_eq!(reasons, ["closes only 55 % of the way", "1 triangle turned over"]);
        assert_eq!(judge(&Findings { along: 0.1, ..closes }).0, Verdict::Look, "a chance touch");
        let (verdict, reasons) = judge(&Findings { amplitude: 1.6, crooked: 0.3, ..FINE });
        assert_eq!(verdict, Verdict::Look);
        assert_eq!(
            reasons,
            ["moves 160 % as far as on the source", "left and right differ by 30 % of the motion"]
        );
    }

    #[test]
    fn what_has_no_counterpart_cannot_be_good() {
        let of = |covered| judge(&Findings { covered, ..FINE }).0;
        assert_eq!([0.6, 0.4, 0.0].map(of), [Verdict::Good, Verdict::Look, Verdict::Bad]);
    }

    #[test]
    fn a_key_that_has_come_to_rest_is_bad() {
        let (verdict, reasons) = judge(&Findings { amplitude: 0.0, ..FINE });
        assert_eq!((verdict, reasons[0].as_str()), (Verdict::Bad, "moves only 0 % as far as on the source"));
    }
}
