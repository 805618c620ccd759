use newtons_cradle::engine::*; use newtons_cradle::model::*; use newtons_cradle::variables::*;
#[test] fn probe(){
  for (name,exponent,hertz,end,n) in [("lin",1.0,false,3.0,3usize),("cub",3.0,false,3.0,3),("hertz",1.5,true,3.0,3),("lin5",1.0,false,10.0,5),("hz5",1.5,true,10.0,5),("hz5L",1.5,true,140.0,5),("lin5L",1.0,false,140.0,5)]{
    let mut p=Parameters{exponent,..Parameters::default_for(n)}; if hertz{p.contact_model=ContactModel::Hertz;}
    let h=History::default();
    let t=std::time::Instant::now(); let mut s=Simulation::new(&p,&Inputs::zero(n),0.0).unwrap(); s.advance(end,&mut Unrecorded).unwrap(); let trun=t.elapsed().as_secs_f64();
    let t=std::time::Instant::now(); let tape=s.tape(&p,0.0,&h).expect(name); let trec=t.elapsed().as_secs_f64();
    let mut w=Differential::zero(n); w.x[1]=1.0; w.v[n-1]=0.3; w.energy=0.1; w.momentum=-2.0; w.impulse[0]=0.7; w.support_force=0.01;
    let t=std::time::Instant::now(); let g=tape.gradient(&w); let tg=t.elapsed().as_secs_f64();
    println!("{name}: run {:.1} us record {:.1} gradient {:.1} ratio {:.1}",trun*1e6,trec*1e6,tg*1e6,(trec+tg)/trun);
    let dot=|d:&Differential| d.x[1]+0.3*d.v[n-1]+0.1*d.energy-2.0*d.momentum+0.7*d.impulse[0]+0.01*d.support_force;
    for known in variables(n).filter(|v| v.row.settable()&&v.row.access.data_type()==Type::Real).filter(|k| !k.row.name.starts_with("solver")) {
      let mut along=Settings::zero(n); known.set_real(&mut along,1.0);
      let f=tape.along(&along.parameters,&along.inputs);
      let a=dot(&f); let b=g.along(&along.parameters,&along.inputs);
      let d=s.sensitivity_of_run(&p,0.0,&h,&along.parameters,&along.inputs).map(|d|dot(&d)).unwrap_or(f64::NAN);
      println!("   {known}: {a:.12e} adj {:.1e} dual {:.1e} {d:.6e}",(a-b)/a.abs().max(1e-300),(a-d)/d.abs().max(1e-300));
    }
  }
}
