% Made from stairs.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(stairs, []).
:- use_module(facetlog(vocabulary)).
% stairs.model:5
model(stairs,
      "A flight of three or more treads of one rise and one going, rising in one direction.",
      [low, middle, high]).

% stairs.model:11  parts
candidate(stairs, Thing, Parts) :-
    findall(Parts, likely(stairs, Thing, Parts), Found),
    ( Found == [] -> distant(stairs, Thing, Parts) ; member(Parts, Found) ).

% stairs.model:11  all that may satisfy its lines
likely(stairs, Thing, [Low, Middle, High]) :-
    face_of(Thing, Low),
    possible(all([measured(Low), level(Low), upward(Low), at_most(share(Low), 0.4),
                  at_least(fill(Low), 0.75)])),
    face_of(Thing, Middle),
    Middle \== Low,
    possible(all([measured(Middle), level(Middle), upward(Middle), at_most(share(Middle), 0.4),
                  at_least(fill(Middle), 0.75), at_least(length(Middle), 1.2*width(Middle))])),
    possible(all([if_known(at_most(overlap(Low, Middle), 0.25)),
                  at_most(angle(Low, Middle), 10),
                  between(area(Low), 0.8*area(Middle), 1.2*area(Middle)),
                  between(offset(Middle, Low), 0.35*width(Middle), width(Middle))])),
    face_of(Thing, High),
    High \== Low,
    High \== Middle,
    possible(all([measured(High), level(High), upward(High), at_most(share(High), 0.4),
                  at_least(fill(High), 0.75)])),
    possible(all([if_known(at_most(overlap(Low, High), 0.25)),
                  if_known(at_most(overlap(Middle, High), 0.25)),
                  between(offset(High, Middle), 0.8*offset(Middle, Low), 1.2*offset(Middle, Low)),
                  at_most(angle(High, Middle), 10),
                  between(area(High), 0.8*area(Middle), 1.2*area(Middle))])).

% stairs.model:11  near misses
distant(stairs, Thing, [Low, Middle, High]) :-
    as_far_as_seen(Thing,
                   [step(Low, 6, all([measured(Low), level(Low), upward(Low)])),
                    step(Middle, 3,
                         all([measured(Middle), level(Middle), upward(Middle),
                              at_most(angle(Low, Middle), 10)])),
                    step(High, 3,
                         all([measured(High), level(High), upward(High),
                              at_most(angle(High, Middle), 10)]))],
                   [Low, Middle, High]).

% stairs.model:12  tread is level, tread is upward, area(tread) at least 20 % of area(middle)
means('stairs.tread'(Tread, Middle),
      all([level(Tread), upward(Tread), soft(at_least(area(Tread), 0.2*area(Middle)), 0.1)])).
% stairs.model:14  riser is upright, length(riser) = length(middle) ± 20 %, height(riser) at most 130 % of rise(low, middle)
means('stairs.riser'(Riser, Low, Middle),
      all([upright(Riser),
           soft(between(length(Riser), 0.8*length(Middle), 1.2*length(Middle)), 0.1),
           soft(at_most(height(Riser), 1.3*offset(Middle, Low)), 0.1)])).

% stairs.model:12
members(stairs, tread, Thing, [Low, Middle, High], Members) :-
    findall(Tread,
            ( face_of(Thing, Tread), \+ memberchk(Tread, [Low, Middle, High]),
              possible('stairs.tread'(Tread, Middle)) ), Found),
    sort(Found, Members).
% stairs.model:14
members(stairs, riser, Thing, [Low, Middle, High], Members) :-
    findall(Riser,
            ( face_of(Thing, Riser), \+ memberchk(Riser, [Low, Middle, High]),
              possible('stairs.riser'(Riser, Low, Middle)) ), Found),
    sort(Found, Members).

% stairs.model:18  each x of low, middle, high: x is measured, x is level, x is upward, share(x) at most 40 %, fill(x) at least 75 %
condition(stairs, part, "three treads are level rectangles, each a part of the plan", _,
          [Low, Middle, High],
          each(X, [Low, Middle, High],
               all([measured(X), level(X), upward(X), soft(at_most(share(X), 0.4), 0.1),
                    soft(at_least(fill(X), 0.75), 0.1)]))).
% stairs.model:20  each pair x, y of low, middle, high: overlap(x, y) at most 25 %
condition(stairs, apart, "the treads lie beside one another, not one above the other", _,
          [Low, Middle, High],
          if_known(each_pair(X, Y, [Low, Middle, High], soft(at_most(overlap(X, Y), 0.25), 0.1)))).
% stairs.model:23  rise(middle, high) = rise(low, middle) ± 20 %, (each x of low, high: angle(x, middle) at most 10 deg, area(x) = area(middle) ± 20 %)
condition(stairs, even_rise, "they rise evenly, and are of one size", _, [Low, Middle, High],
          all([soft(between(offset(High, Middle), 0.8*offset(Middle, Low),
                            1.2*offset(Middle, Low)), 0.1),
               each(X, [Low, High],
                    all([soft(at_most(angle(X, Middle), 10), 0.1),
                         soft(between(area(X), 0.8*area(Middle), 1.2*area(Middle)), 0.1)]))])).
% stairs.model:27  each tread: area(tread) = area(middle) ± 20 %, (rise(low, tread) at most 20 % of rise(low, middle) or rise(tread, middle) at most 20 % of rise(low, middle))
condition(stairs, flight, "so are all others", Thing, [Low, Middle, High],
          each(Tread, Tread_members,
               implies('stairs.tread'(Tread, Middle),
                       all([soft(between(area(Tread), 0.8*area(Middle), 1.2*area(Middle)), 0.1),
                            any([soft(at_most(offset(Tread, Low), 0.2*offset(Middle, Low)), 0.1),
                                 soft(at_most(offset(Middle, Tread), 0.2*offset(Middle, Low)),
                                      0.1)])])))) :-
    members(stairs, tread, Thing, [Low, Middle, High], Tread_members).
% stairs.model:30  each pair x, y of riser: angle(x, y) at most 15 deg
condition(stairs, direction, "the risers face one way", Thing, [Low, Middle, High],
          each_pair(X, Y, Riser_members,
                    implies(all(['stairs.riser'(X, Low, Middle), 'stairs.riser'(Y, Low, Middle)]),
                            soft(at_most(angle(X, Y), 15), 0.1)))) :-
    members(stairs, riser, Thing, [Low, Middle, High], Riser_members).
% stairs.model:32  rise(low, middle) between 35 % of width(middle) and 100 % of width(middle), length(middle) at least 120 % of width(middle)
condition(stairs, pitch,
          "it is neither a ramp nor a ladder, and its treads are broader than deep", _,
          [Low, Middle, _],
          all([soft(between(offset(Middle, Low), 0.35*width(Middle), width(Middle)), 0.1),
               soft(at_least(length(Middle), 1.2*width(Middle)), 0.1)])).
% stairs.model:34  each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright
condition(stairs, straight, "its large faces are level or upright", Thing, [Low, Middle, High],
          each(F, Fs,
               implies(soft(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing)), 0.1),
                       any([level(F), upright(F)])))) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Low, Middle, High]),
              possible(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing))) ),
            Found),
    sort(Found, Fs).
% stairs.model:36  rise(low, middle) between 13 cm and 22 cm
condition(stairs, usual, "steps are 13 cm to 22 cm high", _, [Low, Middle, _],
          expect(0.25,
                 if_known(soft(between(offset(Middle, Low), metres(0.13), metres(0.22)), 0.1)))).

written(stairs, part, 'stairs.model:18',
        "each x of low, middle, high: x is measured, x is level, x is upward, share(x) at most 40 %, fill(x) at least 75 %").
written(stairs, apart, 'stairs.model:20',
        "each pair x, y of low, middle, high: overlap(x, y) at most 25 %").
written(stairs, even_rise, 'stairs.model:23',
        "rise(middle, high) = rise(low, middle) ± 20 %, (each x of low, high: angle(x, middle) at most 10 deg, area(x) = area(middle) ± 20 %)").
written(stairs, flight, 'stairs.model:27',
        "each tread: area(tread) = area(middle) ± 20 %, (rise(low, tread) at most 20 % of rise(low, middle) or rise(tread, middle) at most 20 % of rise(low, middle))").
written(stairs, direction, 'stairs.model:30',
        "each pair x, y of riser: angle(x, y) at most 15 deg").
written(stairs, pitch, 'stairs.model:32',
        "rise(low, middle) between 35 % of width(middle) and 100 % of width(middle), length(middle) at least 120 % of width(middle)").
written(stairs, straight, 'stairs.model:34',
        "each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright").
written(stairs, usual, 'stairs.model:36', "rise(low, middle) between 13 cm and 22 cm").

% stairs.model:12
group(stairs, Thing, [Low, Middle, High], tread, Members) :-
    members(stairs, tread, Thing, [Low, Middle, High], Tread_members),
    findall(Tread, ( member(Tread, Tread_members), holds('stairs.tread'(Tread, Middle)) ),
            Members).
% stairs.model:14
group(stairs, Thing, [Low, Middle, High], riser, Members) :-
    members(stairs, riser, Thing, [Low, Middle, High], Riser_members),
    findall(Riser, ( member(Riser, Riser_members), holds('stairs.riser'(Riser, Low, Middle)) ),
            Members).

% stairs.model:39
size(stairs, _, [Low, Middle, _], rise, offset(Middle, Low)).
% stairs.model:40
size(stairs, _, [_, Middle, _], going, width(Middle)).
% stairs.model:41
size(stairs, _, [_, Middle, _], width, length(Middle)).
