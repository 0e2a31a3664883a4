use borescope::learn::suggest::suggest;
use borescope::record::Record;
use borescope::rig::Rig;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let rig = Rig::read(&a[1]).unwrap();
    let fit = Record::read(&a[2]).unwrap();
    let check = a.get(3).map(|p| Record::read(p).unwrap());
    let t = std::time::Instant::now();
    {
        use borescope::{diagnosis::estimate, model::{Drive, Model}};
        let model = Model::new(rig.clone());
        let drive = Drive::from_record(&model.rig, &fit).unwrap();
    }
    let t = std::time::Instant::now();
    let s = suggest(&rig, &fit, check.as_ref()).unwrap();
    println!("{:?} {:?}", t.elapsed(), s.conclusion);
    let run = |r: &borescope::learn::trial::Run| format!("chi2 {:.3} norm {:.3}", r.chi2, r.normalised);
    println!("base {} | check {} set {:b}", run(&s.base.fit), s.base_check.as_ref().map(run).unwrap_or_default(), s.base.set);
    for c in s.scored.iter().take(12) {
        println!("  score {:12.1} factor {:8.3} own {:.3} smallest {:.3} {} {:?}", c.score, c.factor, c.own, c.smallest, c.id, c.absorbed_by);
    }
    for j in &s.judged {
        println!("{} bic {:.0} fit {} check {} set {:b} supported {} {:?} {:?}", j.id(), j.delta_bic, run(&j.trial.fit), j.check.as_ref().map(run).unwrap_or_default(), j.trial.set, j.supported, j.confounded_with, j.warnings);
        for e in &j.trial.rig.effects { for &p in &e.parameters { let q=&j.trial.rig.parameters[p]; println!("     {} = {:.4} {} +- {:?}", q.id, q.unit.from_si(j.trial.values[p]), q.unit, j.trial.sigmas.get(&p).map(|s| q.unit.difference_from_si(*s))); } }
    }
}
