:- module(facetlog_gallery, [ gallery_verdicts/5,     % +Module, +Model, +Scenes, +Inferences, -Encoded
                              gallery_conditions/3    % +Module, +Model, -Conditions
                            ]).

/** <module> One model on many scenes that stay loaded

What a model says of each scene while its text is being written: verdicts without proofs, with what each
condition says and the values that it compares.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(code)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(batch)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(degrees)).
:- use_module(facetlog_kb(specialise)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(model_descriptions)).

%!  gallery_conditions(+Module, +Model, -Conditions) is det.
%
%   Conditions has condition(Label, Place, Text, Compared) for each condition, in the order of the file;
%   Compared has compared(Measure, Limits) in texts for each measure of single parts.

gallery_conditions(Module, Model, Conditions) :-
    once(Module:model(Model, _, Roles)),
    findall(condition(Label, Place, Text, Compared),
            ( compared_line(Module, Model, Label, Thing, Parts, Comparisons),
              written(Module, Model, Label, Place, Text),
              ( Parts = Roles -> true ; true ),
              ( Thing = this -> true ; true ),
              findall(compared(Measure, Limits),
                      ( member(M-B, Comparisons),
                        sharp(B, Sharp),
                        format(string(Measure), "~w", [M]),
                        format(string(Limits), "~w", [Sharp]) ),
                      Compared) ),
            Conditions).

sharp(Bounds, Sharp) :-
    ( Bounds = soft(Inner, _) ; Bounds = fading(Inner, _) ),
    !,
    sharp(Inner, Sharp).
sharp(Bounds, Bounds).

%   Comparisons are Measure-Bounds of the parts alone; what a quantifier goes through is none.
compared_line(Module, Model, Label, Thing, Parts, Comparisons) :-
    clause(Module:condition(Model, Label, _, Thing, Parts, Test), _),
    findall(Thing-Parts-(M-B),
            ( compared_in(Test, M, B),
              term_variables(M, Variables),
              term_variables(Thing-Parts, Known),
              \+ ( member(V, Variables), \+ ( member(K, Known), K == V ) ) ),
            Found),
    maplist(of_line(Thing-Parts), Found, Comparisons).

of_line(Line, Line-Comparison, Comparison).

compared_in(Test, M, B) :-
    nonvar(Test),
    (   comparison(Test, M0, B0)
    ->  M = M0,
        B = B0
    ;   catch(form(Test, _, tests(Tests), _), error(_, _), fail),
        is_list(Tests),
        member(One, Tests),
        compared_in(One, M, B)
    ).

%!  gallery_verdicts(+Module, +Model, +Scenes, +Inferences, -Encoded) is det.
%
%   Encoded joins, as encoded_verdicts/4 does, for each thing of each of the modules Scenes: the number of the
%   scene, the thing, State, Low, High, and 1 or 0, whether there is more. More are how many parts there are,
%   and each; then State, Low and High of each condition, and of each value that it compares the value and its
%   deviation, or two empty texts. One verdict takes no more than Inferences: else it is unknown.

gallery_verdicts(Module, Model, Scenes, Inferences, Encoded) :-
    findall(Thing-Parts-Ms,
            ( compared_line(Module, Model, _, Thing, Parts, Comparisons),
              pairs_keys(Comparisons, Ms) ),
            Measures),
    findall(Fields,
            ( nth0(Number, Scenes, Scene),
              in_scene(Scene, thing_fields(Module, Model, Measures, Inferences, Rest)),
              Fields = [Number|Rest] ),
            Lists),
    append(Lists, All),
    joined_fields(All, Encoded).

thing_fields(Module, Model, Measures, Inferences, Fields) :-
    fact(thing(Thing)),
    (   catch(call_with_inference_limit(
                  with_code(Module, Model, Target,
                            while_judging(Module, Model, Thing,
                                          one_fields(Target, Module, Model, Thing, Measures, Found))),
                  Inferences, Result),
              error(resource_error(stack), _), Result = inference_limit_exceeded),
        Result \== inference_limit_exceeded
    ->  Fields = [Thing|Found]
    ;   Fields = [Thing, unknown, 0, 1, 0]
    ).

one_fields(Target, Module, Model, Thing, Measures, Fields) :-
    found_in(Target, Module, Model, Thing, _, Found),
    found_fields(Found, Target, Module, Model, Measures, Fields).

found_fields(none, _, _, _, _, [unknown, 0, 1, 0]).
found_fields(refused, _, _, _, _, [fails, 0, 0, 0]).
found_fields(found(Thing, Parts, _), Target, Module, Model, Measures,
             [State, Low, High, 1, Count|Fields]) :-
    all_outlined(Target, Model, Thing, Parts, outline(State, Low, High)),
    roled(Module, Model, Target, Thing, Parts, Roled),
    length(Roled, Count),
    foldl(part_fields, Roled, Fields, Conditions),
    Target:lines(Model, Names),
    foldl(condition_fields(Target, Module, Thing, Parts), Names, Measures, Conditions, []).

condition_fields(Target, Module, Thing, Parts, Name, Measures, [State, Low, High|Values], Rest) :-
    together_outlined([Name], Target, Thing, Parts, outline(State, Low, High)),
    (   Measures = Thing-Parts-Ms
    ->  foldl(value_fields(Module), Ms, Values, Rest)
    ;   Measures = _-_-Ms,
        foldl(no_value, Ms, Values, Rest)
    ).

value_fields(Module, Measure, Fields, Rest) :-
    (   value(Measure, Module, quantity(V, Var, _))
    ->  Sd is sqrt(Var),
        Fields = [V, Sd|Rest]
    ;   Fields = ['', ''|Rest]
    ).

no_value(_, ['', ''|Rest], Rest).
