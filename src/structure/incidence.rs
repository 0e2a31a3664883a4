//! A structural model: which unknowns and faults each equation holds.

#[cfg(feature = "internals")]
use std::fmt;

/// A quantity that no record shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// Its name.
    pub name: String,
    /// Whether a sensor could be put there.
    pub measurable: bool,
}

/// One equation, by the unknowns and faults that it holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Equation {
    /// Its name.
    pub name: String,
    /// Sorted, none twice.
    pub unknowns: Vec<usize>,
    /// Recorded signals.
    pub knowns: Vec<usize>,
    /// Indices among the faults.
    pub faults: Vec<usize>,
    /// Whether it only says that one unknown is the time derivative of another.
    pub differential: bool,
}

/// Equations and what they hold.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Structure {
    /// In the order of their indices.
    pub unknowns: Vec<Unknown>,
    /// Recorded signals, in the order of their indices.
    pub knowns: Vec<String>,
    /// In the order of their indices.
    pub faults: Vec<String>,
    /// In the order of their indices.
    pub equations: Vec<Equation>,
}

/// A relation names something that no list holds.
#[cfg(feature = "internals")]
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownName {
    /// The name.
    pub name: String,
    /// Place of the relation in its list, from 0.
    pub relation: usize,
}

#[cfg(feature = "internals")]
impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "relation {} names `{}`, which is neither unknown, known nor fault", self.relation, self.name)
    }
}

#[cfg(feature = "internals")]
impl std::error::Error for UnknownName {}

impl Structure {
    /// From lists of names: each of `relations` names the variables of one equation, of whatever kind and in any order;
    /// each of `derivatives` is a derivative and what it is the derivative of. Every unknown counts as measurable.
    ///
    /// # Errors
    /// The first name that stands in none of the lists.
    #[cfg(feature = "internals")]
    pub fn from_lists<N: AsRef<str>, R: AsRef<[N]>>(
        unknowns: &[N],
        faults: &[N],
        knowns: &[N],
        relations: &[R],
        derivatives: &[R],
    ) -> Result<Self, UnknownName> {
        let owned = |names: &[N]| names.iter().map(|name| name.as_ref().to_owned()).collect::<Vec<_>>();
        let mut structure = Structure { knowns: owned(knowns), faults: owned(faults), ..Self::default() };
        for name in owned(unknowns) {
            structure.unknown(name, true);
        }
        let find = |list: &[N], name: &str| list.iter().position(|other| other.as_ref() == name);
        let all = relations.iter().map(|names| (names, false)).chain(derivatives.iter().map(|names| (names, true)));
        for (relation, (names, differential)) in all.enumerate() {
            let index = structure.equation(format!("e{}", relation + 1), &[], &[]);
            structure.equations[index].differential = differential;
            for name in names.as_ref() {
                let name = name.as_ref();
                let equation = &mut structure.equations[index];
                match (find(unknowns, name), find(faults, name), find(knowns, name)) {
                    (Some(unknown), _, _) => equation.unknowns.push(unknown),
                    (_, Some(fault), _) => equation.faults.push(fault),
                    (_, _, Some(known)) => equation.knowns.push(known),
                    _ => return Err(UnknownName { name: name.to_owned(), relation }),
                }
            }
            structure.equations[index].tidy();
        }
        Ok(structure)
    }

    /// Adds an unknown; its index.
    pub fn unknown(&mut self, name: impl Into<String>, measurable: bool) -> usize {
        self.unknowns.push(Unknown { name: name.into(), measurable });
        self.unknowns.len() - 1
    }

    /// Adds an equation; its index.
    pub fn equation(&mut self, name: impl Into<String>, unknowns: &[usize], faults: &[usize]) -> usize {
        let mut equation = Equation {
            name: name.into(),
            unknowns: unknowns.to_vec(),
            knowns: Vec::new(),
            faults: faults.to_vec(),
            differential: false,
        };
        equation.tidy();
        self.equations.push(equation);
        self.equations.len() - 1
    }

    /// The unknowns of each equation.
    pub fn rows(&self) -> Vec<&[usize]> {
        self.equations.iter().map(|equation| equation.unknowns.as_slice()).collect()
    }

    /// The equation that each fault breaks, or `None` for a fault that enters no equation. Meant for a structure in
    /// which every fault enters one equation, see [`Structure::one_equation_per_fault`].
    pub fn equation_of_fault(&self) -> Vec<Option<usize>> {
        (0..self.faults.len())
            .map(|fault| self.equations.iter().position(|equation| equation.faults.contains(&fault)))
            .collect()
    }

    /// The same structure with each fault in one equation only: one that enters several becomes an unknown of them, and
    /// the one equation that says it is at its healthy value holds the fault.
    ///
    /// Source: M. Krysander, J. Åslund, M. Nyberg, IEEE Trans. SMC A 38(1), 2008, section II.
    pub fn one_equation_per_fault(&self) -> Self {
        let mut structure = self.clone();
        for (fault, name) in self.faults.iter().enumerate() {
            if self.equations.iter().filter(|equation| equation.faults.contains(&fault)).count() < 2 {
                continue;
            }
            let unknown = structure.unknown(name.clone(), false);
            for equation in &mut structure.equations {
                if equation.faults.contains(&fault) {
                    equation.faults.retain(|other| *other != fault);
                    equation.unknowns.push(unknown);
                }
            }
            structure.equation(format!("{name} is healthy"), &[unknown], &[fault]);
        }
        structure
    }

    /// The same unknowns and faults with only these equations, in this order.
    pub fn only(&self, equations: &[usize]) -> Self {
        let equations = equations.iter().map(|&equation| self.equations[equation].clone()).collect();
        Self { equations, ..self.clone() }
    }

    /// The same structure with one more sensor, which shows `unknown`; `faulty` gives that sensor a fault of its own.
    pub fn with_sensor(&self, unknown: usize, faulty: bool) -> Self {
        let mut structure = self.clone();
        let name = format!("sensor of {}", self.unknowns[unknown].name);
        let mut faults = Vec::new();
        if faulty {
            faults.push(structure.faults.len());
            structure.faults.push(name.clone());
        }
        structure.knowns.push(name.clone());
        let index = structure.equation(name, &[unknown], &faults);
        structure.equations[index].knowns.push(structure.knowns.len() - 1);
        structure
    }
}

impl Equation {
    fn tidy(&mut self) {
        for list in [&mut self.unknowns, &mut self.knowns, &mut self.faults] {
            list.sort_unstable();
            list.dedup();
        }
    }
}
